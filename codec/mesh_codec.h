#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "codec/error.h"
#include "codec/grid_frame.h"
#include "codec/patch_residual.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::codec {

/// Turns a tile's mesh into bytes and back, exactly: decode(encode(m)) holds the same triangles over
/// the same grid addresses. A codec may permute vertices and triangles and rotate a triangle's corners.
/// Stateless: one object serves any number of threads at once.
class MeshCodec {
 public:
  virtual ~MeshCodec() = default;

  /// Deterministic: equal meshes give equal bytes. Fails on a mesh that exceeds the format's limits.
  virtual Expected<std::vector<std::byte>> encode(const TileMesh& mesh) const = 0;

  /// The caller has verified the payload's checksum; the result still has to pass validate().
  virtual Expected<TileMesh> decode(std::span<const std::byte> bytes) const = 0;
};

/// The payload of another tile of the same tree. Any thread.
using PayloadReader = std::function<Expected<std::vector<std::byte>>(const TileId&)>;

/// Decodes the tiles of one tree, also those of methods whose tiles build on the ones above them. Any thread.
class TileDecoder {
 public:
  virtual ~TileDecoder() = default;

  /// As MeshCodec::decode().
  virtual Expected<TileMesh> decode(const TileId& id, std::span<const std::byte> bytes) = 0;

  /// What a tile's patch adds to what its parent's foretells, for a graphics card to make it of; nothing for methods
  /// without patches. Cheap (0.3 ms) for a tile that has just been decoded.
  virtual Expected<std::optional<PatchResidual>> patch_residual(const TileId& id);
};

/// For a tree of the method; null for one that this version lacks. `read` is asked for what a tile builds on, by
/// methods that do.
std::unique_ptr<TileDecoder> make_tile_decoder(std::string_view method, const TreeLayout& layout, PayloadReader read);

/// The most levels_per_doubling that a method's trees may have: 1 where tiles, or their drawing, build on levels whose
/// squares are halved from each to the next.
int most_levels_per_doubling(std::string_view method);

/// The codec of a method as the manifest names it ("tin"), or null for a method this version lacks.
const MeshCodec* find_codec(std::string_view method);

}  // namespace tintree::codec
