#include "tests/support/naive_measure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace tintree::test {
namespace {

using Point = std::array<double, 3>;  // column, row, height
constexpr double kOnLine = 1e-9;

double snapped(double v) { return std::abs(v - std::round(v)) < kOnLine ? std::round(v) : v; }

/// Weights of the corners at a point of the plane; negative outside.
std::array<double, 3> weights(const std::array<Point, 3>& t, double column, double row) {
  const auto cross = [](const Point& a, const Point& b, double c, double r) {
    return (b[0] - a[0]) * (r - a[1]) - (b[1] - a[1]) * (c - a[0]);
  };
  const double area = cross(t[0], t[1], t[2][0], t[2][1]);
  return {cross(t[1], t[2], column, row) / area, cross(t[2], t[0], column, row) / area,
          cross(t[0], t[1], column, row) / area};
}

/// Collects the difference between mesh and surface at single points.
struct Gauge {
  const HeightGrid& grid;
  std::int64_t column0;
  std::int64_t row0;
  std::int64_t across;
  NaiveFigures& figures;

  void at(double column, double row, double height) const {
    // A crossing lies on a grid line by construction: keep it there.
    double c = snapped(column);
    const double r = snapped(row);
    if (std::abs((c - r) - std::round(c - r)) < kOnLine) c = r + std::round(c - r);
    const double difference = std::abs(height - grid.surface(c, r));
    if (std::isnan(difference)) return;
    figures.error_m = std::max(figures.error_m, difference);
  }

  void along(const Point& a, const Point& b) const {
    line(a, b, a[0], b[0]);
    line(a, b, a[1], b[1]);
    line(a, b, a[0] - a[1], b[0] - b[1]);
  }

  /// Crossings of the edge with the lines on which a coordinate, `from` at a and `to` at b, is whole.
  void line(const Point& a, const Point& b, double from, double to) const {
    for (double k = std::ceil(std::min(from, to)); k <= std::max(from, to); ++k) {
      if (from == to) return;
      const double t = (k - from) / (to - from);
      at(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]));
    }
  }

  /// A vertex, or an edge with what lies on it, that lies on a side of the tile's full square.
  void side(const Point& a, const Point& b) const {
    for (const int axis : {0, 1}) {
      const auto k = static_cast<std::size_t>(axis);
      const auto low = static_cast<double>(axis == 0 ? column0 : row0);
      const double high = low + static_cast<double>(across);
      if (a[k] != b[k] || (a[k] != low && a[k] != high)) continue;
      NaiveFigures on_side;
      const Gauge gauge{grid, column0, row0, across, on_side};
      gauge.at(a[0], a[1], a[2]);
      gauge.at(b[0], b[1], b[2]);
      gauge.along(a, b);
      figures.border_error_m = std::max(figures.border_error_m, on_side.error_m);
    }
  }
};

std::array<Point, 3> corners_of(const codec::GridFrame& frame, const codec::TileMesh& mesh, const codec::Triangle& t) {
  std::array<Point, 3> out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const codec::GridVertex& v = mesh.vertices[t[k]];
    out[k] = {frame.column(v.x), frame.row(v.y), frame.height_m(v.z)};
  }
  return out;
}

}  // namespace

double plane_height(const std::array<std::array<double, 3>, 3>& corners, double column, double row) {
  const auto w = weights(corners, column, row);
  return w[0] * corners[0][2] + w[1] * corners[1][2] + w[2] * corners[2][2];
}

NaiveFigures naive_figures(const HeightGrid& grid, const codec::TreeLayout& layout, const codec::TileId& id,
                           const codec::TileMesh& mesh) {
  const codec::GridFrame frame(layout, id, mesh);
  NaiveFigures figures;
  const Gauge gauge{grid, frame.column0, frame.row0, layout.cells_across(id.level), figures};
  figures.z_min_m = std::numeric_limits<double>::infinity();
  figures.z_max_m = -figures.z_min_m;
  for (const codec::GridVertex& v : mesh.vertices) {
    figures.z_min_m = std::min(figures.z_min_m, frame.height_m(v.z));
    figures.z_max_m = std::max(figures.z_max_m, frame.height_m(v.z));
  }
  std::map<std::pair<std::int64_t, std::int64_t>, double> squares;
  for (const codec::Triangle& t : mesh.triangles) {
    const auto p = corners_of(frame, mesh, t);
    const auto [c0, c1] = std::minmax({p[0][0], p[1][0], p[2][0]});
    const auto [r0, r1] = std::minmax({p[0][1], p[1][1], p[2][1]});
    for (std::size_t k = 0; k < 3; ++k) {
      gauge.at(p[k][0], p[k][1], p[k][2]);
      gauge.along(p[k], p[(k + 1) % 3]);
      gauge.side(p[k], p[(k + 1) % 3]);
      gauge.side(p[k], p[k]);
    }
    for (double r = std::ceil(r0); r <= r1; ++r) {
      for (double c = std::ceil(c0); c <= c1; ++c) {
        if (std::ranges::min(weights(p, c, r)) < -1e-12) continue;
        const double z = plane_height(p, c, r);
        gauge.at(c, r, z);
        const auto sample = std::pair{static_cast<std::int64_t>(c), static_cast<std::int64_t>(r)};
        const double d = z - grid.at(sample.first, sample.second);
        if (!std::isnan(d)) squares[sample] = d * d;
      }
    }
  }
  double sum = 0;
  for (const auto& [sample, square] : squares) sum += square;
  figures.rms_m = squares.empty() ? 0 : std::sqrt(sum / static_cast<double>(squares.size()));
  return figures;
}

}  // namespace tintree::test
