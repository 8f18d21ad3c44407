#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/block_tree.h"

namespace tintree::codec {

/// Which vertices and triangles a tile of method `scalar` has (codec/scalar_grid.h). Lengths in address steps.
struct ScalarShape {
  enum Side { kNorth, kEast, kSouth, kWest };

  BlockTree blocks;
  /// Where along each side its vertices lie, rising, from 0 to its length.
  std::array<std::vector<std::int32_t>, 4> sides;

  std::int32_t width() const { return blocks.width(); }
  std::int32_t height() const { return blocks.height(); }
  std::int32_t length(int side) const { return side == kNorth || side == kSouth ? width() : height(); }
  std::size_t border_count() const {
    return sides[kNorth].size() + sides[kEast].size() + sides[kSouth].size() + sides[kWest].size() - 4;
  }
};

}  // namespace tintree::codec
