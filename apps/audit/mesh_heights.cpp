#include "apps/audit/mesh_heights.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tintree::audit {
namespace {

/// A point this far outside a triangle, as a share of its area, is still on it: rounding.
constexpr double kOutside = 1e-9;

}  // namespace

MeshHeights::Grid::Grid(const TileSurface& s)
    : across(std::clamp<std::int64_t>(std::llround(std::sqrt(static_cast<double>(s.triangles.size()))), 1, 512)),
      bin_x(static_cast<double>(s.width_units()) / static_cast<double>(across)),
      bin_y(static_cast<double>(s.height_units()) / static_cast<double>(across)) {}

std::int64_t MeshHeights::Grid::column(double x) const {
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(x / bin_x)), 0, across - 1);
}
std::int64_t MeshHeights::Grid::row(double y) const {
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(y / bin_y)), 0, across - 1);
}
std::size_t MeshHeights::Grid::index(std::int64_t i, std::int64_t j) const {
  return static_cast<std::size_t>(j * across + i);
}

MeshHeights::MeshHeights(const TileSurface& s)
    : surface_(s), grid_(s), triangles_(static_cast<std::size_t>(grid_.across * grid_.across), [&](const auto& put) {
        for (std::uint32_t t = 0; t < s.triangles.size(); ++t) {
          const Corner& a = s.corners[s.triangles[t][0]];
          const Corner& b = s.corners[s.triangles[t][1]];
          const Corner& c = s.corners[s.triangles[t][2]];
          const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
          const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
          for (std::int64_t j = grid_.row(y0); j <= grid_.row(y1); ++j) {
            for (std::int64_t i = grid_.column(x0); i <= grid_.column(x1); ++i) put(grid_.index(i, j), t);
          }
        }
      }) {}

double MeshHeights::at(double column, double row) const {
  const double x = (column - static_cast<double>(surface_.cells.column0)) * surface_.units;
  const double y = (row - static_cast<double>(surface_.cells.row0)) * surface_.units;
  const auto weight = [x, y](const Corner& from, const Corner& to) {
    return (from.x - x) * (to.y - y) - (to.x - x) * (from.y - y);
  };
  for (const std::uint32_t t : triangles_.of(grid_.index(grid_.column(x), grid_.row(y)))) {
    const Corner& a = surface_.corners[surface_.triangles[t][0]];
    const Corner& b = surface_.corners[surface_.triangles[t][1]];
    const Corner& c = surface_.corners[surface_.triangles[t][2]];
    const auto area = static_cast<double>(doubled_area(a, b, c));
    // Rows run southward, hence the signs: inside, all weights have the area's sign.
    const double of_a = -weight(b, c) / area;
    const double of_b = -weight(c, a) / area;
    const double of_c = 1 - of_a - of_b;
    if (std::min({of_a, of_b, of_c}) < -kOutside) continue;
    return of_a * a.z_m + of_b * b.z_m + of_c * c.z_m;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace tintree::audit
