#include "tests/simplify/brute_distance.h"

#include <algorithm>
#include <cmath>

namespace tintree::test {

using simplify::HeightInterval;

namespace {

std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0); }

/// The surface on the grid line through (x, y) in direction (dx, dy), `part` of `whole` of the way on.
double on_line(const BruteSurface& surface, std::int64_t x, std::int64_t y, int dx, int dy, std::int64_t part,
               std::int64_t whole) {
  if (part == 0) return surface.at(x, y);
  const double f = static_cast<double>(part) / static_cast<double>(whole);
  return (1 - f) * surface.at(x, y) + f * surface.at(x + dx, y + dy);
}

}  // namespace

std::int64_t cross(const QuarterPoint& a, const QuarterPoint& b, std::int64_t x, std::int64_t y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

void narrow(double weight, double residual, double bound, HeightInterval& interval) {
  if (std::isnan(residual)) return;
  interval.lo = std::max(interval.lo, (residual - bound) / weight);
  interval.hi = std::min(interval.hi, (residual + bound) / weight);
}

HeightInterval brute_triangle(const BruteSurface& surface, const std::array<QuarterPoint, 3>& t, double bound,
                              HeightInterval interval) {
  const auto& [hub, b, c] = t;
  const std::int64_t area = cross(hub, b, c.x, c.y);
  const auto share = [area](std::int64_t part) { return static_cast<double>(part) / static_cast<double>(area); };
  const auto [left, right] = std::minmax({hub.x, b.x, c.x});
  const auto [top, bottom] = std::minmax({hub.y, b.y, c.y});
  for (std::int64_t y = floor_div(top, 4); 4 * y <= bottom; ++y) {
    for (std::int64_t x = floor_div(left, 4); 4 * x <= right; ++x) {
      const std::int64_t u = cross(b, c, 4 * x, 4 * y);
      const std::int64_t v = cross(c, hub, 4 * x, 4 * y);
      const std::int64_t w = cross(hub, b, 4 * x, 4 * y);
      const bool inside = area > 0 ? u > 0 && v >= 0 && w >= 0 : u < 0 && v <= 0 && w <= 0;
      if (!inside) continue;
      const double plane = share(u) * hub.z + share(v) * b.z + share(w) * c.z;
      narrow(share(u), surface.at(x, y) - plane, bound, interval);
    }
  }
  return interval;
}

HeightInterval brute_spoke(const BruteSurface& surface, const QuarterPoint& hub, const QuarterPoint& end, double bound,
                           HeightInterval interval) {
  // Family k counts x, y or x - y; the coordinate that tells where on the line is y, x or x.
  for (int family = 0; family < 3; ++family) {
    const auto level = [family](const QuarterPoint& v) { return family == 0 ? v.x : family == 1 ? v.y : v.x - v.y; };
    const auto place = [family](const QuarterPoint& v) { return family == 0 ? v.y : v.x; };
    const std::int64_t span = level(end) - level(hub);
    if (span == 0) continue;
    const std::int64_t low = std::min(level(hub), level(end));
    const std::int64_t high = std::max(level(hub), level(end));
    for (std::int64_t k = floor_div(low, 4); 4 * k <= high; ++k) {
      if (4 * k <= low || 4 * k >= high) continue;
      // Share t = step / span of the way; the place is a fraction over 4 |span|.
      const std::int64_t step = 4 * k - level(hub);
      const std::int64_t sign = span < 0 ? -1 : 1;
      const std::int64_t whole = 4 * span * sign;
      const std::int64_t at = sign * (place(hub) * span + step * (place(end) - place(hub)));
      const std::int64_t cell = floor_div(at, whole);
      const std::int64_t x = family == 0 ? k : cell;
      const std::int64_t y = family == 0 ? cell : family == 1 ? k : cell - k;
      const double height = on_line(surface, x, y, family == 0 ? 0 : 1, family == 1 ? 0 : 1, at - cell * whole, whole);
      const double t = static_cast<double>(step) / static_cast<double>(span);
      narrow(1 - t, height - (hub.z + t * (end.z - hub.z)), bound, interval);
    }
  }
  return interval;
}

bool holds(const HeightInterval& outer, const HeightInterval& inner) {
  const double rounding = 1e-9 + 1e-7 * (std::abs(inner.lo) + std::abs(inner.hi));
  return inner.empty() || (inner.lo >= outer.lo - rounding && inner.hi <= outer.hi + rounding);
}

}  // namespace tintree::test
