#pragma once

#include <algorithm>

namespace tintree::simplify {

/// An axis-parallel rectangle in samples, sides included.
struct Extent {
  double x0, y0, x1, y1;

  bool empty() const { return x0 > x1 || y0 > y1; }
  bool holds(const Extent& r) const { return r.x0 >= x0 && r.y0 >= y0 && r.x1 <= x1 && r.y1 <= y1; }
};

inline Extent overlap(const Extent& a, const Extent& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

}  // namespace tintree::simplify
