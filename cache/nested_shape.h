#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/grid_frame.h"
#include "codec/nested_tile.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::cache {

/// A vertex of a NestedShape as a vertex buffer takes it: 24 bytes (shaders/nested.vert.glsl unpacks it).
struct NestedVertex {
  std::uint32_t xy = 0;    ///< Address steps from the tile's north-west corner: lower 16 bits of x, then of y.
  std::uint32_t rest = 0;  ///< 22 bits of z, then the upper 3 bits of x and of y.
  /// How far above it the meshes of levels 0 to 7 are, in NestedShape::units.
  std::array<std::int8_t, codec::NestedTile::kMostLevels - 1> rises{};
  std::array<std::int16_t, 2> normal{};         ///< East and north of the unit normal on level 8, times 32767.
  std::array<std::int8_t, 4> coarse_normals{};  ///< The same on level 7 and on level 6, times 127.

  std::int32_t x() const { return static_cast<std::int32_t>((xy & 0xffffU) | (rest >> 22 & 7U) << 16); }
  std::int32_t y() const { return static_cast<std::int32_t>(xy >> 16 | (rest >> 25 & 7U) << 16); }
  std::int32_t z() const { return static_cast<std::int32_t>(rest & 0x3fffffU); }
};
static_assert(sizeof(NestedVertex) == 24);

/// A vertex of a tile's outline.
struct BorderVertex {
  std::int64_t along = 0;  ///< Its place along the side's line, in half samples of the DEM.
  std::uint32_t vertex = 0;
  /// Bit i: on level i surface lies along the side from here to the level's next vertex on it.
  std::uint16_t joined_levels = 0;
};

/// A tile of method `nested` ready to be drawn at nine levels of detail (Schneider and Westermann 2006), on whichever
/// surface lies between two of them: level 8 is the tile's own mesh, level 8 - k the mesh of its ancestor k levels up.
/// So what is drawn of a place depends on the level there, and not on which tile draws it. Levels above the root are
/// the root's own nested ones. The points of all these meshes are those of one hierarchy of right triangles, so level i
/// needs the first level_vertices[i] of the vertices. Level i is within 2^(8 - i) of the tile's level's bounds of the
/// DEM's surface. Immutable once made.
struct NestedShape {
  static constexpr int kLevels = codec::NestedTile::kMostLevels;

  codec::GridFrame frame;  ///< Takes the vertices' addresses to metres; its steps may be finer than the stored ones.
  std::int32_t side = 0;   ///< Of the tile, address steps.
  std::vector<NestedVertex> vertices;
  std::array<float, kLevels - 1> units{};  ///< Height steps of a unit of the rises.
  codec::NestedFans fans;
  std::array<std::vector<BorderVertex>, 4> borders;  ///< West, north, east, south; ascending.
  std::uint16_t skirt_sides = 0;                     ///< SkirtSide bits: behind which the ground goes on.
  std::vector<codec::NestedGap> gaps;                ///< Points of the hierarchy without surface.

  std::size_t level_vertices(int level) const { return fans.level_vertices[static_cast<std::size_t>(level)]; }
  const std::vector<std::uint32_t>& level_fans(int level) const { return fans.fans[static_cast<std::size_t>(level)]; }
  std::size_t bytes() const;
};

struct DrawableTile;

/// Whether a mesh is one of method `nested` over the tile's square. Of what NestedMaker makes, all are.
bool can_have_nested_shape(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh);

/// Of a mesh that can have one and has passed validate(). `drawable`: its arrays, for their normals;
/// `error_m`: what is stored of it, TileInfo::lod_error_m(). `joined_sides` as make_drawable() takes them. `parent`:
/// the shape of the parent, or null for the root, and where the parent is lost: then levels 0 to 7 are, of the nested
/// ones in the payload, the coarsest that keep within their bounds. Cost: about 2 us a vertex.
NestedShape make_nested_shape(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh,
                              const DrawableTile& drawable, double error_m, std::uint16_t joined_sides,
                              const NestedShape* parent);

}  // namespace tintree::cache
