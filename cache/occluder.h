#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "codec/grid_frame.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::cache {

/// What a tile's surface is sure to hide, and how high it is at most, in a few kilobytes: lower bounds of its
/// height along lines from side to side (the idea of Lloyd and Egbert, "Horizon occlusion culling for
/// real-time rendering of hierarchical terrains", 2002, with lines that hold for the mesh as it is drawn and
/// not only for samples), and planes above it. Immutable once made; any thread.
struct Occluder {
  /// The tile's cells are divided in so many strips each way; lines run between them and along the sides.
  static constexpr std::size_t kStrips = 16;
  static constexpr std::size_t kLines = kStrips + 1;
  /// World heights, metres, at the crossings with the other lines: the line that joins them lies on the
  /// surface or below it everywhere.
  using Line = std::array<float, kLines>;
  /// A plane above one cell between lines: see top_m().
  struct Plane {
    float z_m = 0;       ///< At the cell's first corner (least column, least row).
    float rise_u_m = 0;  ///< Over the cell's width, along the columns' way,
    float rise_v_m = 0;  ///< and along the rows' way.
  };

  codec::CellRect cells;
  /// The surface has no hole. When it has, the vectors are empty: nothing is sure to be hidden.
  bool closed = false;
  std::vector<Line> row_lines;     ///< Line j runs along the columns' way, j / kStrips of the rows down.
  std::vector<Line> column_lines;  ///< Line i runs along the rows' way, i / kStrips of the columns across.
  std::vector<Plane> planes;       ///< Of the kStrips x kStrips cells, row by row.

  /// Upper bound of the surface's height, metres, at a place of the grid inside `cells`; infinite when the
  /// tile is not closed.
  double top_m(double column, double row) const;
  std::size_t bytes() const;
};

/// `mesh` has passed validate(). Cost: about 0.1 us a triangle, and the memory of Occluder::bytes().
Occluder make_occluder(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh);

}  // namespace tintree::cache
