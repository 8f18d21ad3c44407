#pragma once

#include <cmath>
#include <cstdint>

namespace tintree::simplify {

/// Heights of one level: whole multiples of a step, the same for all its tiles. A mesh counts them from an origin near
/// its own heights.
struct HeightLattice {
  double step_m = 1;
  std::int64_t origin = 0;  ///< z = 0 lies so many steps above height 0.

  /// The nearest multiple, in steps from height 0.
  std::int64_t address(double height_m) const { return std::llround(height_m / step_m); }
  double snapped_m(double height_m) const { return static_cast<double>(address(height_m)) * step_m; }
  /// The same in steps from the origin, which must lie within 2^31 steps.
  std::int32_t snap(double height_m) const { return static_cast<std::int32_t>(address(height_m) - origin); }
  double height_m(std::int32_t z) const { return static_cast<double>(origin + z) * step_m; }
};

}  // namespace tintree::simplify
