#include "codec/mesh_codec.h"

#include <algorithm>
#include <array>
#include <utility>

#include "codec/draco_mesh.h"
#include "codec/nested_mesh.h"
#include "codec/scalar_codec.h"
#include "codec/strip_mesh.h"
#include "codec/wavelet_tiles.h"

namespace tintree::codec {
namespace {

/// Of methods whose payloads stand alone.
class PlainDecoder final : public TileDecoder {
 public:
  explicit PlainDecoder(const MeshCodec& codec) : codec_(&codec) {}
  Expected<TileMesh> decode(const TileId&, std::span<const std::byte> bytes) override { return codec_->decode(bytes); }

 private:
  const MeshCodec* codec_;
};

}  // namespace

Expected<std::optional<PatchResidual>> TileDecoder::patch_residual(const TileId&) { return std::nullopt; }

const MeshCodec* find_codec(std::string_view method) {
  struct Method {
    std::string_view name;
    const MeshCodec* codec;
  };
  static const DracoMesh tin;
  static const NestedMesh nested;
  static const StripMesh strip;
  static const ScalarCodec scalar;
  static const WaveletMesh wavelet;
  /// One row a method, as in simplify/tile_maker.cpp.
  static const std::array methods{Method{"tin", &tin}, Method{"strip", &strip}, Method{"nested", &nested},
                                  Method{"wavelet", &wavelet}, Method{"scalar", &scalar}};
  const auto* found = std::ranges::find(methods, method, &Method::name);
  return found == methods.end() ? nullptr : found->codec;
}

int most_levels_per_doubling(std::string_view method) { return method == "wavelet" || method == "nested" ? 1 : 2; }

std::unique_ptr<TileDecoder> make_tile_decoder(std::string_view method, const TreeLayout& layout, PayloadReader read) {
  if (method == "wavelet") return std::make_unique<WaveletDecoder>(layout, std::move(read));
  const MeshCodec* codec = find_codec(method);
  return codec == nullptr ? nullptr : std::make_unique<PlainDecoder>(*codec);
}

}  // namespace tintree::codec
