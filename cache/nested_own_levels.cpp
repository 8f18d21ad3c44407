#include "cache/nested_own_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "codec/nested_points.h"

namespace tintree::cache {
namespace {

constexpr std::size_t kFinest = NestedShape::kLevels - 1;
using Heights = NestedShapePoint::Heights;

/// How far each of the payload's levels is from the DEM at most.
Heights largest_errors(const std::vector<NestedShapePoint>& points, double error_steps) {
  Heights out{};
  for (const NestedShapePoint& p : points) {
    for (std::size_t k = 0; k <= kFinest && !p.gap; ++k)
      out[k] = std::max(out[k], std::abs(p.z[k] - p.z[kFinest]) + error_steps);
  }
  return out;
}

}  // namespace

void choose_own_levels(std::vector<NestedShapePoint>& points, double bound_steps, double error_steps) {
  const Heights errors = largest_errors(points, error_steps);
  std::array<std::size_t, NestedShape::kLevels> chosen{};
  chosen[kFinest] = kFinest;
  for (std::size_t k = kFinest; k-- > 0;) {
    const double allowed_steps = std::ldexp(bound_steps, static_cast<int>(kFinest - k));
    chosen[k] = chosen[k + 1];
    while (chosen[k] > 0 && errors[chosen[k] - 1] <= allowed_steps) --chosen[k];
  }
  for (NestedShapePoint& p : points) {
    const Heights z = p.z;
    for (std::size_t k = 0; k <= kFinest; ++k) p.z[k] = z[chosen[k]];
    const auto first = std::ranges::lower_bound(chosen, static_cast<std::size_t>(p.level));
    p.level = static_cast<int>(first - chosen.begin());
  }
  for (std::size_t i = 0; i < codec::NestedPoints::kBasePoints; ++i) points[i].level = 0;
}

}  // namespace tintree::cache
