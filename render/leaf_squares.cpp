#include "render/leaf_squares.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace tintree::render {

bool LeafSquares::are_on(const cache::TileBounds& bounds, const cache::TileNode& node) {
  return bounds.texture_depth() > 0 && bounds.layout().is_leaf_square(node.id.level);
}

LeafSquares::LeafSquares(const cache::TileBounds& bounds, const cache::TileNode& leaf)
    : bounds_(&bounds), leaf_(&leaf), leaf_box_(bounds.box(leaf)) {}

double LeafSquares::texel_m(const LeafSquare& s) const {
  return std::ldexp(bounds_->texel_m(leaf_->id.level), -s.depth);
}

codec::TileId LeafSquares::id(const LeafSquare& s) const {
  const codec::TreeLayout& layout = bounds_->layout();
  return {layout.coarsest_level(layout.halvings(leaf_->id.level) + s.depth), column(s), row(s)};
}

double LeafSquares::cells_across(const LeafSquare& s) const {
  return std::ldexp(static_cast<double>(bounds_->layout().tile_cells), -s.depth);
}

bool LeafSquares::is_beyond(const LeafSquare& s) const {
  const codec::TreeLayout& layout = bounds_->layout();
  return column(s) * cells_across(s) >= static_cast<double>(layout.columns - 1) ||
         row(s) * cells_across(s) >= static_cast<double>(layout.rows - 1);
}

cache::Box LeafSquares::box(const LeafSquare& s) const {
  if (s.depth == 0) return leaf_box_;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const double cells = cells_across(s);
  cache::Box box{{kFar, kFar, leaf_box_.min[2]}, {-kFar, -kFar, leaf_box_.max[2]}};
  for (std::uint32_t corner = 0; corner < 4; ++corner) {
    const auto at = bounds_->layout().world((column(s) + (corner & 1U)) * cells, (row(s) + (corner >> 1U)) * cells);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      box.min[axis] = std::min(box.min[axis], at[axis]);
      box.max[axis] = std::max(box.max[axis], at[axis]);
    }
  }
  return box;
}

}  // namespace tintree::render
