#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "codec/mesh_codec.h"
#include "codec/patch_cache.h"
#include "codec/wavelet_patch.h"

namespace tintree::codec {

/// Method `wavelet` (Yusov & Turlapov 2008). A tile's payload (docs/format.md) is the patch of its level's layer, coded
/// against its parent's reconstructed one, and its right triangles, whose heights are coded against that patch.

/// Patches hold whole numbers of a quarter of their level's height step, which doubles with every level up.
inline constexpr std::int64_t kUnitsAStep = 4;

/// What a tile's patch is coded against: its parent's reconstructed patch, or nothing (null) at the root.
Patch wavelet_prediction(const TreeLayout& layout, const TileId& id, const Patch* parent);

/// The payload of a tile whose patch has been coded.
Expected<std::vector<std::byte>> encode_wavelet_tile(const TreeLayout& layout, const TileId& id, const TileMesh& mesh,
                                                     const EncodedPatch& patch);

class WaveletDecoder final : public TileDecoder {
 public:
  WaveletDecoder(const TreeLayout& layout, PayloadReader read) : layout_(layout), read_(std::move(read)) {}

  /// Cost: 1 to 5 ms for a patch of 256 cells, as much for each of those above that were not used lately.
  Expected<TileMesh> decode(const TileId& id, std::span<const std::byte> bytes) override;
  Expected<std::optional<PatchResidual>> patch_residual(const TileId& id) override;

 private:
  Expected<Patch> prediction(const TileId& id);
  Expected<std::shared_ptr<const Patch>> patch(const TileId& id);
  Expected<std::shared_ptr<const Patch>> take_patch(const TileId& id, std::span<const std::byte>& bytes);

  TreeLayout layout_;
  PayloadReader read_;
  std::mutex turn_;  // of the cache
  PatchCache<Patch> patches_;
};

/// A tile of this method is no bytes by itself: both ways fail and say so. WaveletMaker encodes, WaveletDecoder
/// decodes.
class WaveletMesh final : public MeshCodec {
 public:
  Expected<std::vector<std::byte>> encode(const TileMesh& mesh) const override;
  Expected<TileMesh> decode(std::span<const std::byte> bytes) const override;
};

}  // namespace tintree::codec
