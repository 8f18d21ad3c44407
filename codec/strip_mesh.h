#pragma once

#include "codec/mesh_codec.h"

namespace tintree::codec {

/// Method `strip` (Dick, Schneider, Westermann 2009): a restricted quadtree mesh as one generalised triangle strip, two
/// bits of type and one height a triangle, in sub-strips of 16 that can be decoded each for itself (docs/format.md).
/// encode() takes restricted quadtree meshes, with holes, and no others.
class StripMesh final : public MeshCodec {
 public:
  Expected<std::vector<std::byte>> encode(const TileMesh& mesh) const override;
  /// Of either payload version. Of this one it follows the strip and compares every header with it; refuses a strip
  /// that leaves its square, but does not look whether it overlaps itself (the payload's checksum does).
  Expected<TileMesh> decode(std::span<const std::byte> bytes) const override;
};

}  // namespace tintree::codec
