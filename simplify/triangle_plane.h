#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tintree::simplify {

/// A point over a tile: x eastward and y southward in samples from the tile's north-west sample, z metres.
struct Point {
  double x = 0;
  double y = 0;
  double z = 0;
};

/// Coordinates this near to a grid line are on it.
inline constexpr double kOnGridLine = 1e-9;

/// A triangle's height and the hub's weight in it as affine functions, and its outline as half-planes.
struct TrianglePlane {
  double z0, zx, zy;  // height at (0, 0), its slopes
  double w0, wx, wy;  // weight at (0, 0), its slopes
  double area;        // in cells
  std::array<Point, 3> corner;
  // The triangle's part of row y runs from max(left[k] + y left_slope[k]) to min(right[k] + y right_slope[k]).
  std::array<double, 2> left{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  std::array<double, 2> left_slope{};
  std::array<double, 2> right{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::array<double, 2> right_slope{};

  TrianglePlane(const Point& hub, const Point& b, const Point& c) : corner{hub, b, c} {
    const double scale = 1 / ((hub.x - c.x) * (b.y - c.y) - (b.x - c.x) * (hub.y - c.y));
    wx = (b.y - c.y) * scale;
    wy = (c.x - b.x) * scale;
    w0 = -wx * c.x - wy * c.y;
    const double ux = (c.y - hub.y) * scale;
    const double uy = (hub.x - c.x) * scale;
    const double u0 = -ux * c.x - uy * c.y;
    zx = wx * (hub.z - c.z) + ux * (b.z - c.z);
    zy = wy * (hub.z - c.z) + uy * (b.z - c.z);
    z0 = c.z + w0 * (hub.z - c.z) + u0 * (b.z - c.z);
    const bool mirrored = scale < 0;
    area = std::abs(0.5 / scale);
    std::size_t lefts = 0;
    std::size_t rights = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Point& p = corner[i];
      const Point& q = corner[i == 2 ? 0 : i + 1];
      if (p.y == q.y) continue;
      const double slope = (q.x - p.x) / (q.y - p.y);
      const double start = p.x - p.y * slope;
      if ((q.y < p.y) != mirrored) {
        left[lefts] = start;
        left_slope[lefts++] = slope;
      } else {
        right[rights] = start;
        right_slope[rights++] = slope;
      }
    }
  }

  double height(double x, double y) const { return z0 + zx * x + zy * y; }
  double weight(double x, double y) const { return w0 + wx * x + wy * y; }
  double min_x() const { return std::min({corner[0].x, corner[1].x, corner[2].x}); }
  double max_x() const { return std::max({corner[0].x, corner[1].x, corner[2].x}); }
  double min_y() const { return std::min({corner[0].y, corner[1].y, corner[2].y}); }
  double max_y() const { return std::max({corner[0].y, corner[1].y, corner[2].y}); }

  std::int64_t first_row() const { return static_cast<std::int64_t>(std::ceil(min_y() - kOnGridLine)); }
  std::int64_t last_row() const { return static_cast<std::int64_t>(std::floor(max_y() + kOnGridLine)); }
  /// Whole coordinates of row y, one of the triangle's, inside it.
  std::int64_t first_in(double y) const {
    return static_cast<std::int64_t>(
        std::ceil(std::max(left[0] + y * left_slope[0], left[1] + y * left_slope[1]) - kOnGridLine));
  }
  std::int64_t last_in(double y) const {
    return static_cast<std::int64_t>(
        std::floor(std::min(right[0] + y * right_slope[0], right[1] + y * right_slope[1]) + kOnGridLine));
  }

  /// Whether the square lies wholly outside one of the triangle's edges.
  bool misses(double x0, double y0, double x1, double y1) const {
    for (std::size_t k = 0; k < 2; ++k) {
      if (x1 < left[k] + left_slope[k] * (left_slope[k] > 0 ? y0 : y1)) return true;
      if (x0 > right[k] + right_slope[k] * (right_slope[k] > 0 ? y1 : y0)) return true;
    }
    return y1 < min_y() || y0 > max_y();
  }
};

}  // namespace tintree::simplify
