#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "simplify/extent.h"
#include "simplify/triangle_plane.h"

namespace tintree::simplify {

/// The squares of each row, of those over an extent, that lie outside none of a triangle's sides, or touch one from
/// outside.
class SquareRows {
 public:
  /// `first` is the extent's north-western square.
  SquareRows(const TrianglePlane& plane, const Extent& first, const Extent& extent)
      : last_(std::ceil((extent.x1 - first.x0) / (first.x1 - first.x0)) - 1) {
    for (std::size_t k = 0; k < 3; ++k) {
      const TrianglePlane::Side& s = plane.sides[k];
      // Where the row reaches farthest inside. A side along the rows leaves out all of a row or nothing of it.
      const double inside = s.at(s.x > 0 ? first.x1 : first.x0, s.y > 0 ? first.y1 : first.y0);
      const double unit = s.x == 0 ? kFar : 1 / (std::abs(s.x) * (first.x1 - first.x0));
      if (s.x > 0)
        wests_[k] = {-inside * unit, -s.y * unit};
      else
        easts_[k] = {(s.x == 0 ? inside + 0.5 : inside) * unit, s.y * unit};
    }
  }

  struct Columns {
    std::int64_t first;
    std::int64_t end;
  };
  /// Squares are counted from the extent's first one eastward; of the row that begins `y` samples south of it.
  Columns at(std::int64_t y) const {
    const auto south = static_cast<double>(y);
    double first = 0;
    double last = last_;
    for (const Line& west : wests_) first = std::max(first, west.at(south));
    for (const Line& east : easts_) last = std::min(last, east.at(south));
    // Rounded up and down.
    if (last < first - 2 * kSlack) return {0, 0};
    return {static_cast<std::int64_t>(first + (1 - kSlack)), static_cast<std::int64_t>(last + kSlack) + 1};
  }

 private:
  static constexpr double kSlack = 1e-6;
  static constexpr double kFar = 1e12;

  /// Where a side lies, in squares.
  struct Line {
    double start, per_row;
    double at(double y) const { return start + y * per_row; }
  };
  std::array<Line, 3> wests_{};  // as good as none: where the extent begins
  std::array<Line, 3> easts_{{{kFar, 0}, {kFar, 0}, {kFar, 0}}};
  double last_;
};

}  // namespace tintree::simplify
