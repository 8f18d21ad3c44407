#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <optional>
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
  std::int64_t height_step = 1;  ///< Heights inside the tile are multiples of so many height steps,
  /// or those of these, rising, that are as near: (height_step - 1) / 2 steps at most.
  std::vector<std::int64_t> levels;
  /// border_places() of its sides.
  std::array<std::vector<std::int32_t>, 4> sides;

  std::int32_t width() const { return sides[codec::ScalarShape::kNorth].back(); }
  std::int32_t height() const { return sides[codec::ScalarShape::kWest].back(); }
  /// The height that a vertex gets, in steps from height 0; `height_m` is the sample there.
  std::int64_t address(std::int32_t x, std::int32_t y, double height_m) const {
    const std::int64_t z = level.heights.address(height_m);
    if (x == 0 || y == 0 || x == width() || y == height()) return z;
    if (const auto near = nearest_level(z); near && std::abs(*near - z) <= (height_step - 1) / 2) return *near;
    const HeightLattice coarse{level.heights.step_m * static_cast<double>(height_step)};
    return height_step * coarse.address(height_m);
  }
  std::optional<std::int64_t> nearest_level(std::int64_t z) const {
    const auto above = std::ranges::lower_bound(levels, z);
    if (above == levels.begin()) return levels.empty() ? std::nullopt : std::optional(*above);
    return above == levels.end() || z - above[-1] <= *above - z ? above[-1] : *above;
  }
};

/// The coarsest blocks that keep the bound, as far as splitting from the widest on finds them; a block of a stride
/// above 1 in which a sample is missing is split, and empty where all are. At stride 1 all heights keep the bound that
/// are within kRowShare of it. To be thrown away when the view is interrupted afterwards. Memory: 4 bytes a block;
/// cost: that of SurfaceDistance, twice or three times.
codec::ScalarShape choose_blocks(SurfaceView& view, ScalarSpec spec);

}  // namespace tintree::simplify
