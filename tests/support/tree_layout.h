#pragma once

#include <cstdint>

#include "codec/grid_frame.h"

namespace tintree::test {

/// The layout of a tree over so many samples, 30.5 x 28.25 m apart, at an error of 0.75 m and height steps of 0.125 m.
inline codec::TreeLayout make_layout(std::int64_t columns, std::int64_t rows, int tile_cells,
                                     int levels_per_doubling = 1) {
  codec::TreeLayout layout;
  layout.columns = columns;
  layout.rows = rows;
  layout.tile_cells = tile_cells;
  layout.levels_per_doubling = levels_per_doubling;
  layout.leaf_level = codec::TreeLayout::leaf_level_for(columns, rows, tile_cells, levels_per_doubling);
  layout.dx_m = 30.5;
  layout.dy_m = 28.25;
  layout.leaf_error_m = 0.75;
  layout.z_step_m.assign(static_cast<std::size_t>(layout.leaf_level) + 1, 0.125);
  return layout;
}

}  // namespace tintree::test
