#include "cache/nested_shape_packing.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "cache/drawable_tile.h"
#include "codec/nested_points.h"

namespace tintree::cache {
namespace {

constexpr std::size_t kFinest = NestedShape::kLevels - 1;
/// Finer height steps than the stored ones, as digits: points that only coarser levels have lie between those.
constexpr int kFinerZ = 4;

using Point = NestedShapePoint;

template <typename To>
To packed(float share) {
  return static_cast<To>(std::lround(share * static_cast<float>(std::numeric_limits<To>::max())));
}

/// By their levels, the five first.
void add_fans(std::vector<Point>& points, NestedShape& shape) {
  std::stable_sort(points.begin() + codec::NestedPoints::kBasePoints, points.end(),
                   [](const Point& a, const Point& b) { return a.level < b.level; });
  codec::NestedPoints hierarchy(std::countr_zero(static_cast<std::uint32_t>(shape.side)));
  for (const Point& p : points) {
    hierarchy.add({p.x, p.y, 0, static_cast<std::uint8_t>(p.level), p.gap});
    if (p.gap) shape.gaps.push_back({p.x, p.y, static_cast<std::uint8_t>(p.level)});
  }
  shape.fans = codec::nested_fans(hierarchy, NestedShape::kLevels);
}

/// `finer`: digits of the vertices' heights below the points'.
NestedVertex pack(const Point& p, int finer, const NestedShape& shape) {
  const auto x = static_cast<std::uint32_t>(p.x);
  const auto y = static_cast<std::uint32_t>(p.y);
  const auto z = static_cast<std::uint32_t>(std::llround(std::ldexp(p.z[kFinest], finer)));
  NestedVertex out;
  out.xy = (x & 0xffffU) | y << 16;
  out.rest = z | (x >> 16) << 22 | (y >> 16) << 25;
  for (std::size_t k = 0; k < kFinest; ++k) {
    const double rise = std::ldexp(p.z[k] - p.z[kFinest], finer) / static_cast<double>(shape.units[k]);
    out.rises[k] = static_cast<std::int8_t>(std::lround(rise));
  }
  out.normal = {packed<std::int16_t>(p.normals[0][0]), packed<std::int16_t>(p.normals[0][1])};
  out.coarse_normals = {packed<std::int8_t>(p.normals[1][0]), packed<std::int8_t>(p.normals[1][1]),
                        packed<std::int8_t>(p.normals[2][0]), packed<std::int8_t>(p.normals[2][1])};
  return out;
}

void add_vertices(const std::vector<Point>& points, double bound_steps, NestedShape& shape) {
  const auto point = [&points](std::int32_t i) -> const Point& { return points[static_cast<std::size_t>(i)]; };
  double highest = 1;
  Point::Heights largest{};
  for (const std::int32_t i : shape.fans.vertex_points) {
    const Point& p = point(i);
    highest = std::max(highest, p.z[kFinest]);
    for (std::size_t k = 0; k < kFinest; ++k) largest[k] = std::max(largest[k], std::abs(p.z[k] - p.z[kFinest]));
  }
  int finer = kFinerZ;
  while (finer > 0 && std::ldexp(highest, finer) > DrawVertex::kMostZ) --finer;
  shape.frame.z_offset <<= finer;
  shape.frame.z_step_m = std::ldexp(shape.frame.z_step_m, -finer);
  for (std::size_t k = 0; k < kFinest; ++k) {
    // A 64th of the level's tolerance, or what a byte needs.
    double unit = std::ldexp(bound_steps, static_cast<int>(kFinest - k) - 6 + finer);
    while (std::ldexp(largest[k], finer) > 127 * unit) unit *= 2;
    shape.units[k] = static_cast<float>(unit);
  }
  for (const std::int32_t i : shape.fans.vertex_points) shape.vertices.push_back(pack(point(i), finer, shape));
}

}  // namespace

NestedShape pack_nested_shape(std::vector<NestedShapePoint> points, const codec::GridFrame& frame, std::int32_t side,
                              double bound_steps) {
  NestedShape shape;
  shape.frame = frame;
  shape.side = side;
  add_fans(points, shape);
  add_vertices(points, bound_steps, shape);
  return shape;
}

}  // namespace tintree::cache
