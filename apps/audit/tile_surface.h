#pragma once

#include <cstdint>
#include <vector>

#include "codec/grid_frame.h"
#include "codec/tile_mesh.h"

namespace tintree::audit {

/// Rasters wider or higher than this cannot be measured in 64-bit integers.
inline constexpr std::int64_t kMaxSide = std::int64_t{1} << 27;

/// A mesh vertex on the tile's lattice: whole numbers only, so that every incidence is decided exactly.
struct Corner {
  std::int32_t x = 0;       ///< Eastward from the tile's north-west sample, in lattice units.
  std::int32_t y = 0;       ///< Southward.
  std::int64_t height = 0;  ///< Global height address, in the level's height steps.
  double z_m = 0;
};

/// An edge of the mesh, listed once. An open edge has one triangle, which runs it from a to b.
struct Edge {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  bool open = false;
};

/// A decoded tile, placed over its DEM cells for measuring. Immutable once made.
struct TileSurface {
  codec::CellRect cells;    ///< The tile's cells, cut to the raster.
  std::int64_t across = 0;  ///< Cells along the side of the uncut tile.
  int units = 1;            ///< Lattice units per DEM sample: 1, 2, 4 or 8.
  std::vector<Corner> corners;
  std::vector<codec::Triangle> triangles;
  std::vector<Edge> edges;
  std::uint64_t overused_edges = 0;  ///< Edges of more than two triangles, or run twice the same way.

  std::int32_t width_units() const { return static_cast<std::int32_t>((cells.column1 - cells.column0) * units); }
  std::int32_t height_units() const { return static_cast<std::int32_t>((cells.row1 - cells.row0) * units); }
};

/// Twice the area of a triangle seen from above, in lattice units squared; positive when counter-clockwise.
inline std::int64_t doubled_area(const Corner& a, const Corner& b, const Corner& c) {
  return (std::int64_t{c.x} - a.x) * (std::int64_t{b.y} - a.y) - (std::int64_t{b.x} - a.x) * (std::int64_t{c.y} - a.y);
}

/// Places a validated mesh. The raster's sides must not exceed kMaxSide. Linear time.
TileSurface place(const codec::TreeLayout& layout, const codec::TileId& id, codec::TileMesh mesh);

}  // namespace tintree::audit
