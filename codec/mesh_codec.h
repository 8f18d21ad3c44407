#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "codec/error.h"
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

/// The codec of a method as the manifest names it ("tin"), or null for a method this version lacks.
const MeshCodec* find_codec(std::string_view method);

}  // namespace tintree::codec
