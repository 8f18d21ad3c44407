#pragma once

#include <cmath>
#include <cstdint>

namespace tintree::simplify {

/// Heights of one level: whole multiples of a step, counted from height 0, the same for all its tiles.
struct HeightLattice {
  double step_m = 1;

  std::int32_t snap(double height_m) const { return static_cast<std::int32_t>(std::lround(height_m / step_m)); }
  double height_m(std::int32_t z) const { return z * step_m; }
  double snapped_m(double height_m_in) const { return height_m(snap(height_m_in)); }
};

}  // namespace tintree::simplify
