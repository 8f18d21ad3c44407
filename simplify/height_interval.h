#pragma once

namespace tintree::simplify {

/// Heights that a vertex may take, relative to a height that the caller chose. Empty when lo > hi.
struct HeightInterval {
  double lo = 0;
  double hi = 0;

  bool empty() const { return lo > hi; }

  /// Narrows the interval to what one point allows: the mesh's height there changes by `weight` (positive) of the
  /// vertex's change, and the surface lies `residual` above it for the height that the interval is relative to.
  void clip(double weight, double residual, double bound_m) {
    if (residual - bound_m > lo * weight) lo = (residual - bound_m) / weight;
    if (residual + bound_m < hi * weight) hi = (residual + bound_m) / weight;
  }
};

}  // namespace tintree::simplify
