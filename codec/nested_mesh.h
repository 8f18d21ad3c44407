#pragma once

#include "codec/mesh_codec.h"
#include "codec/nested_points.h"

namespace tintree::codec {

/// The codec of method `nested`: a block of bytes for each nested level, which adds the level's vertices to those of
/// the levels before it. What is stored is where triangles are split and the heights there, range coded; which
/// triangles that makes goes without saying (docs/format.md).
class NestedMesh final : public MeshCodec {
 public:
  /// `mesh` as simplify::NestedMaker makes it: its triangles are those of NestedPoints over its vertices and gaps.
  /// Refuses any other, and tiles more than 2^18 address steps wide.
  Expected<std::vector<std::byte>> encode(const TileMesh& mesh) const override;
  Expected<TileMesh> decode(std::span<const std::byte> bytes) const override;
};

/// The mesh of all points, with the level of each vertex. Points without a triangle are its gaps.
TileMesh finest_mesh(const NestedPoints& points);

}  // namespace tintree::codec
