#include "tests/bench/rivals/mesh_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace tintree::bench {
namespace {

constexpr double kOnLine = 1e-7;  // of a sample spacing

struct Point {
  double column;
  double row;
  double z_m;
};
using Corners = std::array<Point, 3>;

Point between(const Point& a, const Point& b, double t) {
  return {a.column + t * (b.column - a.column), a.row + t * (b.row - a.row), a.z_m + t * (b.z_m - a.z_m)};
}

double snapped(double v) { return std::abs(v - std::round(v)) < kOnLine ? std::round(v) : v; }

/// A sample that no triangle of the surface has for a corner is no part of it.
HeightGrid without_lone_samples(const HeightGrid& grid) {
  HeightGrid out{grid.columns, grid.rows, grid.dx_m, grid.dy_m, {}};
  out.heights_m.assign(grid.heights_m.size(), std::numeric_limits<double>::quiet_NaN());
  const auto keep = [&](int column, int row) {
    const auto i =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(column);
    out.heights_m[i] = grid.heights_m[i];
  };
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const bool lower = grid.has_lower(column, row);
      const bool upper = grid.has_upper(column, row);
      if (lower || upper) keep(column, row), keep(column + 1, row + 1);
      if (lower) keep(column, row + 1);
      if (upper) keep(column + 1, row);
    }
  }
  return out;
}

class Meter {
 public:
  explicit Meter(const HeightGrid& grid)
      : grid_(without_lone_samples(grid)),
        distance_m_(grid.heights_m.size(), kUncovered),
        filled_(grid.heights_m.size()) {
    error_.map_m.assign(grid.heights_m.size(), std::numeric_limits<float>::quiet_NaN());
  }

  void add(const Corners& t) {
    for (std::size_t k = 0; k < 3; ++k) {
      at(t[k]);
      along(t[k], t[(k + 1) % 3]);
    }
    scan(t);
    const double area =
        (t[1].column - t[0].column) * (t[2].row - t[0].row) - (t[2].column - t[0].column) * (t[1].row - t[0].row);
    if (area >= 0) ++error_.folded;  // rows run southward: counter-clockwise is negative
  }

  MeshError result() const {
    MeshError out = error_;
    double squares = 0;
    std::uint64_t covered = 0;
    for (std::size_t i = 0; i < distance_m_.size(); ++i) {
      const double d = distance_m_[i];
      if (filled_[i]) ++out.filled;
      if (d == kUncovered) continue;
      ++covered;
      squares += d * d;
      out.samples_max_m = std::max(out.samples_max_m, d);
    }
    out.surface_max_m = std::max(out.surface_max_m, out.samples_max_m);
    const auto missing = std::ranges::count_if(grid_.heights_m, [](double height) { return std::isnan(height); });
    out.uncovered = distance_m_.size() - static_cast<std::uint64_t>(missing) - covered;
    out.rms_m = covered == 0 ? 0 : std::sqrt(squares / static_cast<double>(covered));
    return out;
  }

 private:
  static constexpr double kUncovered = -1;

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid_.columns) + static_cast<std::size_t>(column);
  }

  void into_map(int column, int row, double distance) {
    float& slot = error_.map_m[index(column, row)];
    if (!(slot >= distance)) slot = static_cast<float>(distance);
  }

  void at(const Point& p) {
    const double column = snapped(p.column);
    const double row = snapped(p.row);
    if (column < 0 || row < 0 || column > grid_.columns - 1 || row > grid_.rows - 1) return;
    const double distance = std::abs(p.z_m - grid_.surface(column, row));
    if (std::isnan(distance)) return;
    error_.surface_max_m = std::max(error_.surface_max_m, distance);
    into_map(static_cast<int>(std::lround(column)), static_cast<int>(std::lround(row)), distance);
  }

  /// The edge where it crosses the grid's columns, rows and diagonals.
  void along(const Point& a, const Point& b) {
    crossings(a, b, a.column, b.column);
    crossings(a, b, a.row, b.row);
    crossings(a, b, a.column - a.row, b.column - b.row);
  }

  /// Where a coordinate, `from` at a and `to` at b, is whole.
  void crossings(const Point& a, const Point& b, double from, double to) {
    if (from == to) return;
    for (double k = std::ceil(std::min(from, to)); k <= std::max(from, to); ++k) {
      at(between(a, b, (k - from) / (to - from)));
    }
  }

  /// The samples under the triangle, row by row.
  void scan(const Corners& t) {
    const auto [low, high] = std::minmax({t[0].row, t[1].row, t[2].row});
    const int first = std::max(0, static_cast<int>(std::ceil(low - kOnLine)));
    const int last = std::min(grid_.rows - 1, static_cast<int>(std::floor(high + kOnLine)));
    for (int row = first; row <= last; ++row) {
      Point west{std::numeric_limits<double>::infinity(), 0, 0};
      Point east{-std::numeric_limits<double>::infinity(), 0, 0};
      for (std::size_t k = 0; k < 3; ++k) cut(t[k], t[(k + 1) % 3], row, west, east);
      compare(west, east, row);
    }
  }

  /// Widens [west, east] by what the edge has on the row.
  static void cut(const Point& a, const Point& b, int row, Point& west, Point& east) {
    const auto widen = [&](const Point& p) {
      if (p.column < west.column) west = p;
      if (p.column > east.column) east = p;
    };
    const bool a_on = std::abs(a.row - row) < kOnLine;
    const bool b_on = std::abs(b.row - row) < kOnLine;
    if (a_on) widen(a);
    if (b_on) widen(b);
    if (!a_on && !b_on && (a.row < row) != (b.row < row)) widen(between(a, b, (row - a.row) / (b.row - a.row)));
  }

  void compare(const Point& west, const Point& east, int row) {
    if (!(west.column <= east.column)) return;
    const int first = std::max(0, static_cast<int>(std::ceil(west.column - kOnLine)));
    const int last = std::min(grid_.columns - 1, static_cast<int>(std::floor(east.column + kOnLine)));
    const double width = east.column - west.column;
    for (int column = first; column <= last; ++column) {
      const double t = width > 0 ? std::clamp((column - west.column) / width, 0.0, 1.0) : 0;
      const double distance = std::abs(between(west, east, t).z_m - grid_.at(column, row));
      if (std::isnan(distance)) {
        filled_[index(column, row)] = true;
        continue;
      }
      double& slot = distance_m_[index(column, row)];
      slot = std::max(slot, distance);
      into_map(column, row, distance);
    }
  }

  const HeightGrid grid_;
  std::vector<double> distance_m_;
  std::vector<bool> filled_;
  MeshError error_;
};

}  // namespace

MeshError measure(const HeightGrid& grid, const TriangleMesh& mesh) {
  Meter meter(grid);
  for (const auto& triangle : mesh.triangles) {
    Corners corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& [x, y, z] = mesh.vertices[triangle[k]];
      corners[k] = {snapped(x / grid.dx_m), snapped(-y / grid.dy_m), z};
    }
    meter.add(corners);
  }
  return meter.result();
}

}  // namespace tintree::bench
