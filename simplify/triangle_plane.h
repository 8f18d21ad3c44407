#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "simplify/extent.h"
#include "simplify/sample_rect.h"

namespace tintree::simplify {

/// A point over a tile: x eastward and y southward in samples from the tile's north-west sample, z metres.
struct Point {
  double x = 0;
  double y = 0;
  double z = 0;
};

/// Coordinates this near to a grid line are on it.
inline constexpr double kOnGridLine = 1e-9;
/// Corners lie on multiples of 1 / kCornerParts samples.
inline constexpr int kCornerParts = 4;

/// A triangle's height and the hub's weight in it as linear functions, and its sides as half-planes.
struct TrianglePlane {
  double z0, zx, zy;  // height at (0, 0), its slopes
  double w0, wx, wy;  // weight at (0, 0), its slopes
  double area;        // in cells
  std::array<Point, 3> corner;
  /// Twice the area against each side in units of 1 / kCornerParts^2 cells, exact: not negative inside. The first
  /// two sides meet at the hub.
  struct Side {
    double start, x, y;
    double at(double px, double py) const { return start + x * px + y * py; }
  };
  std::array<Side, 3> sides;
  Extent extent;

  TrianglePlane(const Point& hub, const Point& b, const Point& c) : corner{hub, b, c} {
    const double doubled = (hub.x - c.x) * (b.y - c.y) - (b.x - c.x) * (hub.y - c.y);
    const double scale = 1 / doubled;
    wx = (b.y - c.y) * scale;
    wy = (c.x - b.x) * scale;
    w0 = -wx * c.x - wy * c.y;
    const double ux = (c.y - hub.y) * scale;
    const double uy = (hub.x - c.x) * scale;
    const double u0 = -ux * c.x - uy * c.y;
    zx = wx * (hub.z - c.z) + ux * (b.z - c.z);
    zy = wy * (hub.z - c.z) + uy * (b.z - c.z);
    z0 = c.z + w0 * (hub.z - c.z) + u0 * (b.z - c.z);
    area = std::abs(0.5 * doubled);
    const double sign = doubled < 0 ? -1.0 * kCornerParts * kCornerParts : 1.0 * kCornerParts * kCornerParts;
    sides[0] = side_along(c, hub, sign);
    sides[1] = side_along(hub, b, sign);
    sides[2] = side_along(b, c, sign);
    extent = {std::min(std::min(hub.x, b.x), c.x), std::min(std::min(hub.y, b.y), c.y),
              std::max(std::max(hub.x, b.x), c.x), std::max(std::max(hub.y, b.y), c.y)};
  }

  double height(double x, double y) const { return z0 + zx * x + zy * y; }
  double weight(double x, double y) const { return w0 + wx * x + wy * y; }
  bool contains(double x, double y) const {
    return sides[0].at(x, y) >= 0 && sides[1].at(x, y) >= 0 && sides[2].at(x, y) >= 0;
  }
  /// Whether the rectangle lies wholly outside one of the triangle's sides.
  bool misses(const Extent& r) const {
    return std::ranges::any_of(sides,
                               [&](const Side& s) { return s.at(s.x > 0 ? r.x1 : r.x0, s.y > 0 ? r.y1 : r.y0) < 0; });
  }

  /// The triangle over the rectangle of samples from (x, y), at most kMaxRectSamples along each side.
  RectTriangle over(std::int64_t x, std::int64_t y, double base_m) const {
    const auto px = static_cast<double>(x);
    const auto py = static_cast<double>(y);
    RectTriangle out;
    out.height = {height(px, py) - base_m, zx, zy};
    out.weight = {weight(px, py), wx, wy};
    for (std::size_t k = 0; k < 3; ++k) out.sides[k] = over(sides[k], px, py);
    return out;
  }

 private:
  static constexpr double kFarSide = 1 << 30;
  static constexpr double kMostSteep = 1 << 24;

  /// A side over a rectangle. Exact up to 2^20 samples of length; of longer ones, whose areas do not fit, a margin less
  /// than 2^-16 samples wide counts as inside.
  static Linear<std::int32_t> over(const Side& side, double px, double py) {
    const double steepness = std::abs(side.x) + std::abs(side.y);
    if (steepness <= kMostSteep) {
      return {static_cast<std::int32_t>(std::clamp(side.at(px, py), -kFarSide, kFarSide)),
              static_cast<std::int32_t>(side.x), static_cast<std::int32_t>(side.y)};
    }
    const double unit = steepness / kMostSteep;
    // What rounding down may take from a sample's value.
    constexpr double kMargin = 2 * kMaxRectSamples;
    // So far inside or outside, no sample of the rectangle lies on the other side.
    const double start = std::clamp(std::ceil(side.at(px, py) / unit) + kMargin, -kFarSide, kFarSide);
    return {static_cast<std::int32_t>(start), static_cast<std::int32_t>(std::floor(side.x / unit)),
            static_cast<std::int32_t>(std::floor(side.y / unit))};
  }

  static Side side_along(const Point& p, const Point& q, double sign) {
    const double x = (p.y - q.y) * sign;
    const double y = (q.x - p.x) * sign;
    return {-(x * p.x + y * p.y), x, y};
  }
};

}  // namespace tintree::simplify
