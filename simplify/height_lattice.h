#pragma once

#include <cstdint>

namespace tintree::simplify {

/// Heights of one level: whole multiples of a step, the same for all its tiles. A mesh counts them from an origin near
/// its own heights.
struct HeightLattice {
  double step_m = 1;
  std::int64_t origin = 0;  ///< z = 0 lies so many steps above height 0.

  /// The nearest multiple, in steps from height 0.
  /// The height is a number and fewer than 2^63 steps from 0.
  std::int64_t address(double height_m) const {
    // As std::llround does, without its call: this rounds every sample in the search for splits.
    const double steps = height_m / step_m;
    const auto whole = static_cast<std::int64_t>(steps);
    const double rest = steps - static_cast<double>(whole);
    return whole + static_cast<int>(rest >= 0.5) - static_cast<int>(rest <= -0.5);
  }
  double snapped_m(double height_m) const { return static_cast<double>(address(height_m)) * step_m; }
  /// The same in steps from the origin, which must lie within 2^31 steps.
  std::int32_t snap(double height_m) const { return static_cast<std::int32_t>(address(height_m) - origin); }
  double height_m(std::int32_t z) const { return static_cast<double>(origin + z) * step_m; }
};

}  // namespace tintree::simplify
