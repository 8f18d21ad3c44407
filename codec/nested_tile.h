#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/error.h"
#include "codec/nested_points.h"
#include "codec/tile_mesh.h"

namespace tintree::codec {

/// The nested meshes of a hierarchy over shared vertices, without the vertices.
struct NestedFans {
  /// Between two fans of an index array.
  static constexpr std::uint32_t kRestart = 0xffffffffU;

  std::vector<std::int32_t> vertex_points;  ///< The point that each vertex is.
  std::vector<std::uint32_t> level_vertices;
  /// Each level's triangles as fans, counter-clockwise from above, kRestart between them.
  std::vector<std::vector<std::uint32_t>> fans;
  std::vector<std::uint32_t> level_triangles;
};

/// Of the levels below `levels`. The points come in the order of their levels; gaps are no vertices. Cost: about 0.2 us
/// a vertex.
NestedFans nested_fans(const NestedPoints& points, int levels);

/// A tile of method `nested` (Schneider and Westermann 2006) as it is drawn: nested meshes M_0, the coarsest, to
/// M_(levels - 1), the tile's own, over shared vertices. Level i uses the first level_vertices[i] of them, so a finer
/// level needs only what comes behind. A plain value.
struct NestedTile {
  static constexpr int kMostLevels = 9;
  int xy_shift = 0;           ///< As TileMesh.
  std::int64_t z_offset = 0;  ///< As TileMesh.
  int levels = 0;             ///< That were read: 1 to kMostLevels.
  std::vector<GridVertex> vertices;
  std::vector<std::uint32_t> level_vertices;
  /// As NestedFans.
  std::vector<std::vector<std::uint32_t>> fans;
  std::vector<std::uint32_t> level_triangles;
  /// How far above a vertex each coarser mesh is at its place: of M_i, in units of 2^morph_exponent[i] height steps,
  /// rounded. 0 where M_i has the vertex. A unit is a 64th of the level's tolerance if that is a quarter of a bound a
  /// step, twice that and so on where a byte would not hold the tile's largest.
  std::vector<std::array<std::int8_t, kMostLevels - 1>> morphs;
  std::array<std::int8_t, kMostLevels - 1> morph_exponent{};

  /// Of M_i, above the height origin, at vertex v.
  double height(std::size_t v, int i) const;
};

/// Reads a payload of method `nested` up to and without level `levels`, of the levels that it has the coarser ones. The
/// bytes behind the blocks of these may be missing. Fails with kBadData on what is not such a payload. Cost: about 0.3
/// us a vertex. Levels are those of the payload that were read.
Expected<NestedTile> decode_nested(std::span<const std::byte> bytes, int levels = NestedTile::kMostLevels);

/// Of a payload: how many bytes a reader needs for its first 1, 2, ... levels.
Expected<std::vector<std::size_t>> nested_prefix_bytes(std::span<const std::byte> bytes);

}  // namespace tintree::codec
