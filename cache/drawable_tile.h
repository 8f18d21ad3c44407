#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "cache/occluder.h"
#include "codec/grid_frame.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::cache {

/// Sides of a tile's square on the grid, as bits: which way the skirt of a border vertex faces.
enum SkirtSide : std::uint16_t { kSkirtWest = 1, kSkirtEast = 2, kSkirtNorth = 4, kSkirtSouth = 8 };

/// One vertex as a vertex buffer takes it: 20 bytes.
struct DrawVertex {
  float x = 0;                ///< Address steps east of the tile's north-west corner; exact up to 2^24.
  float y = 0;                ///< Address steps south of it.
  float z = 0;                ///< Height steps above the tile's height origin; exact, the format has 22 bits.
  std::uint16_t skirt = 0;    ///< 0 on the surface; else SkirtSide bits: draw it pushed down and that way.
  std::int16_t normal_x = 0;  ///< Unit normal in the world frame (metres), east part times 32767.
  std::int16_t normal_y = 0;  ///< North part; the up part is positive and follows from the unit length.
};
static_assert(sizeof(DrawVertex) == 20);

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

/// A tile ready for upload. Immutable once made.
struct DrawableTile {
  codec::TileId id;
  codec::GridFrame frame;  ///< Takes the vertices' addresses to metres.
  std::vector<DrawVertex> vertices;
  std::vector<std::uint32_t> indices;  ///< Triangles, counter-clockwise from above: the surface, then the skirt.
  std::uint32_t surface_triangles = 0;
  std::optional<MorphMesh> morph;            ///< None for a tile that does not morph.
  std::shared_ptr<const Occluder> occluder;  ///< What the surface hides; never null.

  std::size_t bytes() const {
    return sizeof *this + vertices.size() * sizeof(DrawVertex) + indices.size() * sizeof(std::uint32_t) +
           (morph ? morph->bytes() : 0) + occluder->bytes();
  }
};

/// Makes the arrays of one decoded tile. Every vertex gets the mean of its triangles' normals in metres
/// with the weights of Max, "Weights for Computing Vertex Normals from Facet Normals" (1999), which stay
/// fair where large flat triangles meet small steep ones. Every edge on a side of the square behind which
/// the raster goes on gets two skirt triangles down to copies of its ends.
/// `mesh` has passed validate(). Cost: about 0.1 us a vertex.
DrawableTile make_drawable(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh);

}  // namespace tintree::cache
