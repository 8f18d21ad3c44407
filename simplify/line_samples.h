#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "simplify/height_lattice.h"
#include "simplify/surface_window.h"

namespace tintree::simplify {

/// The samples along a row or a column of a window, and how far edges between them are from the others.
class LineSamples {
 public:
  /// Those from (x, y) to `cells` samples further, eastward or southward.
  void read(const SurfaceWindow& surface, std::int64_t x, std::int64_t y, std::int64_t cells, bool southward) {
    samples_.resize(static_cast<std::size_t>(cells) + 1);
    for (std::int64_t i = 0; i <= cells; ++i)
      samples_[static_cast<std::size_t>(i)] = southward ? surface.sample(x, y + i) : surface.sample(x + i, y);
  }

  /// Whether the edge from sample `first` to sample `first` + n, its ends snapped, is within the bound of all between.
  /// True where an end is missing; a missing sample between is as good as one that fits.
  bool edge_fits(std::int64_t first, std::int64_t n, const HeightLattice& heights, double bound_m) const {
    const double* h = &samples_[static_cast<std::size_t>(first)];
    if (std::isnan(h[0] + h[n])) return true;
    const double from = heights.snapped_m(h[0]);
    const double rise = (heights.snapped_m(h[n]) - from) / static_cast<double>(n);
    for (std::int64_t i = 1; i < n; ++i) {
      if (std::abs(from + rise * static_cast<double>(i) - h[i]) > bound_m) return false;
    }
    return true;
  }

 private:
  std::vector<double> samples_;
};

}  // namespace tintree::simplify
