#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "codec/scalar_shape.h"
#include "simplify/level_grid.h"
#include "simplify/reference_surface.h"

namespace tintree::simplify {

/// How a tile of method `scalar` is to be.
struct ScalarSpec {
  LevelGrid level;
  std::int64_t column0 = 0;  ///< Of its north-west sample.
  std::int64_t row0 = 0;
  double bound_m = 0;  ///< What the test allows at strides above 1: guard taken off, and what is kept for later.
  std::int64_t height_step = 1;  ///< Heights inside the tile are multiples of so many height steps.
  /// border_places() of its sides.
  std::array<std::vector<std::int32_t>, 4> sides;

  std::int32_t width() const { return sides[codec::ScalarShape::kNorth].back(); }
  std::int32_t height() const { return sides[codec::ScalarShape::kWest].back(); }
  /// The height that a vertex gets, in steps from height 0; `height_m` is the sample there.
  std::int64_t address(std::int32_t x, std::int32_t y, double height_m) const {
    if (x == 0 || y == 0 || x == width() || y == height()) return level.heights.address(height_m);
    const HeightLattice coarse{level.heights.step_m * static_cast<double>(height_step)};
    return height_step * coarse.address(height_m);
  }
};

/// The coarsest blocks that keep the bound, as far as splitting from the widest on finds them; a block of a stride
/// above 1 in which a sample is missing is split, and empty where all are. At stride 1 all heights keep the bound that
/// are within kRowShare of it. To be thrown away when the view is interrupted afterwards. Memory: 4 bytes a block;
/// cost: that of SurfaceDistance, twice or three times.
codec::ScalarShape choose_blocks(SurfaceView& view, ScalarSpec spec);

}  // namespace tintree::simplify
