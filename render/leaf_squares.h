#pragma once

#include <cstdint>

#include "cache/tile_bounds.h"
#include "codec/tile_id.h"

namespace tintree::render {

/// A square in a leaf: which, of a grid with `1 << depth` squares a side.
struct LeafSquare {
  int depth = 0;
  std::uint32_t x = 0;
  std::uint32_t y = 0;

  /// In TileId's order.
  LeafSquare quadrant(std::uint32_t q) const { return {depth + 1, 2 * x + (q & 1U), 2 * y + (q >> 1U)}; }
};

/// The squares that a leaf is halved into for textures finer than its own (Manifest::picture_layout()). Cheap to make;
/// `bounds` and `leaf` must outlive it.
class LeafSquares {
 public:
  /// Whether leaves of the tree are halved, and the node lies on a leaf's square.
  static bool are_on(const cache::TileBounds& bounds, const cache::TileNode& node);

  LeafSquares(const cache::TileBounds& bounds, const cache::TileNode& leaf);

  bool is_finest(const LeafSquare& s) const { return s.depth == bounds_->texture_depth(); }
  /// Side of the texels of the square's texture.
  double texel_m(const LeafSquare& s) const;
  /// The name of its texture.
  codec::TileId id(const LeafSquare& s) const;
  /// Whether it lies beyond the DEM's east or south side.
  bool is_beyond(const LeafSquare& s) const;
  /// Round the square, and as high as the leaf's.
  cache::Box box(const LeafSquare& s) const;

 private:
  /// The place of a square among all of its size.
  std::uint32_t column(const LeafSquare& s) const { return (leaf_->id.x << s.depth) + s.x; }
  std::uint32_t row(const LeafSquare& s) const { return (leaf_->id.y << s.depth) + s.y; }
  double cells_across(const LeafSquare& s) const;

  const cache::TileBounds* bounds_;
  const cache::TileNode* leaf_;
  cache::Box leaf_box_;
};

}  // namespace tintree::render
