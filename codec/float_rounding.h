#pragma once

#include <cmath>
#include <limits>

namespace tintree::codec {

/// The largest float not above `v`.
inline float round_down(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) <= v ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}

/// The smallest float not below `v`.
inline float round_up(double v) { return -round_down(-v); }

}  // namespace tintree::codec
