#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "cache/native_ground.h"
#include "cache/occluder.h"
#include "cache/tile_pictures.h"
#include "cache/tile_relief.h"
#include "codec/grid_frame.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::cache {

/// Sides of a tile's square on the grid, as bits: which way the skirt of a border vertex faces.
enum SkirtSide : std::uint16_t { kSkirtWest = 1, kSkirtEast = 2, kSkirtNorth = 4, kSkirtSouth = 8 };

/// Where a tile's mesh ends towards other tiles.
struct TileOutline {
  std::uint16_t sides = 0;  ///< SkirtSide bits of those behind which the ground goes on.
  std::int64_t east = 0;    ///< Addresses of its ends; a tile that the raster's end cuts short ends there.
  std::int64_t south = 0;
};
/// Of a tile with addresses of 2^xy_shift samples. The ground goes on where the raster does, and on those of the
/// raster's own sides that `joined_sides` (SkirtSide bits) says another tree joins.
TileOutline tile_outline(const codec::TreeLayout& layout, const codec::TileId& id, int xy_shift,
                         std::uint16_t joined_sides);

/// One vertex as a vertex buffer takes it: 12 bytes (shaders/terrain.vert.glsl unpacks it).
struct DrawVertex {
  std::uint16_t x_low = 0;  ///< Address steps east of the tile's north-west corner: the lower 16 bits.
  std::uint16_t y_low = 0;  ///< Address steps south of it.
  std::uint16_t z_low = 0;  ///< Height steps above the tile's height origin.
  /// Bits 0 to 3: SkirtSide, 0 on the surface; then the upper 3 bits of x, 3 of y and 6 of z.
  std::uint16_t high = 0;
  std::int16_t normal_x = 0;  ///< Unit normal in the world frame (metres), east part times 32767.
  std::int16_t normal_y = 0;  ///< North part; the up part is positive and follows from the unit length.

  static constexpr std::int32_t kMostXy = (1 << 19) - 1;
  static constexpr std::int32_t kMostZ = (1 << 22) - 1;

  /// x and y in 0..kMostXy, z in 0..kMostZ.
  static DrawVertex pack(std::int32_t x, std::int32_t y, std::int32_t z);
  std::int32_t x() const { return x_low | (high >> 4 & 7) << 16; }
  std::int32_t y() const { return y_low | (high >> 7 & 7) << 16; }
  std::int32_t z() const { return z_low | (high >> 10) << 16; }
  /// SkirtSide bits: draw it pushed down and that way.
  std::uint16_t skirt() const { return high & 15; }
};
static_assert(sizeof(DrawVertex) == 12);

/// One vertex of a surface between a tile's and its parent's: 28 bytes.
struct MorphVertex {
  float x = 0;  ///< Address steps, as in DrawVertex, with fractions.
  float y = 0;
  float z = 0;       ///< Height steps of the tile's own surface
  float goal_z = 0;  ///< and of its parent's, both above the tile's height origin.
  std::int16_t normal_x = 0;
  std::int16_t normal_y = 0;
  std::int16_t goal_normal_x = 0;
  std::int16_t goal_normal_y = 0;
  std::uint16_t skirt = 0;
  std::uint16_t unused = 0;
};
static_assert(sizeof(MorphVertex) == 28);

/// The overlay of a tile with its parent (cache/morph.h).
struct MorphMesh {
  std::vector<MorphVertex> vertices;
  std::vector<std::uint32_t> indices;  ///< The surface, then the skirt.
  std::uint32_t surface_triangles = 0;

  std::size_t bytes() const { return vertices.size() * sizeof(MorphVertex) + indices.size() * sizeof(std::uint32_t); }
};

/// A tile ready for upload: a mesh, or a NativeGround; or, on a square in a leaf, a finer texture of it, with
/// `pictures` only. Immutable once made.
struct DrawableTile {
  codec::TileId id;
  codec::GridFrame frame;  ///< Takes the vertices' addresses to metres.
  std::vector<DrawVertex> vertices;
  /// Triangles, counter-clockwise from above: the surface, then the skirt. In 16 bits where all vertices can be named
  /// so, else in 32; the other list is empty.
  std::vector<std::uint16_t> indices;
  std::vector<std::uint32_t> wide_indices;
  std::uint32_t surface_triangles = 0;
  std::optional<MorphMesh> morph;            ///< None for a tile that does not morph.
  std::shared_ptr<const Occluder> occluder;  ///< What the surface hides; null without a surface.
  TilePictures pictures;                     ///< make_drawable() leaves them out,
  std::optional<TileRelief> relief;          ///< and this: of tiles that are lit by their patch.
  NativeGround native;                       ///< What is drawn in the mesh's place; make_drawable() leaves it out.

  /// Of a tile with so many vertices.
  void set_indices(std::vector<std::uint32_t> all, std::size_t vertex_count);
  std::size_t index_count() const { return indices.size() + wide_indices.size(); }
  std::uint32_t index(std::size_t i) const { return indices.empty() ? wide_indices[i] : indices[i]; }
  std::size_t vertex_bytes() const { return vertices.size() * sizeof(DrawVertex); }
  std::size_t index_bytes() const { return 2 * indices.size() + 4 * wide_indices.size(); }
  std::size_t bytes() const {
    return sizeof *this + vertex_bytes() + index_bytes() + (morph ? morph->bytes() : 0) +
           (occluder ? occluder->bytes() : 0) + pictures.bytes() + (relief ? relief->bytes() : 0) + native.bytes();
  }
};

/// Makes the arrays of one decoded tile. Every vertex gets the mean of its triangles' normals in metres
/// with the weights of Max, "Weights for Computing Vertex Normals from Facet Normals" (1999), which stay
/// fair where large flat triangles meet small steep ones. Every edge on a side of the square behind which
/// the ground goes on gets two skirt triangles down to copies of its ends: where the raster does, and on those of the
/// raster's own sides that `joined_sides` (SkirtSide bits) says another tree joins.
/// `mesh` has passed validate(). A tile more than 2^19 address steps wide is rounded to what 19 bits hold, a
/// thousandth of a pixel where all of it is in view. Cost: about 0.1 us a vertex.
DrawableTile make_drawable(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh,
                           std::uint16_t joined_sides = 0);

}  // namespace tintree::cache
