#include "render/tree_placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cache/drawable_tile.h"

namespace tintree::render {
namespace {

using Vector = std::array<double, 2>;

/// A linear map of the plane.
struct Map {
  Vector x{1, 0};  ///< Where (1, 0) goes,
  Vector y{0, 1};  ///< and (0, 1).

  Vector operator()(const Vector& v) const { return {v[0] * x[0] + v[1] * y[0], v[0] * x[1] + v[1] * y[1]}; }
};

/// The map that takes two vectors to two others.
Map map_of(const Vector& from_a, const Vector& from_b, const Vector& to_a, const Vector& to_b) {
  const double area = from_a[0] * from_b[1] - from_a[1] * from_b[0];
  const auto image = [&](double u, double v) -> Vector {
    const double a = (u * from_b[1] - v * from_b[0]) / area;
    const double b = (from_a[0] * v - from_a[1] * u) / area;
    return {a * to_a[0] + b * to_b[0], a * to_a[1] + b * to_b[1]};
  };
  return {image(1, 0), image(0, 1)};
}

Vector column_step(const cache::Manifest& m) { return {m.geotransform[1], m.geotransform[4]}; }
Vector row_step(const cache::Manifest& m) { return {m.geotransform[2], m.geotransform[5]}; }
/// Centre of the first sample in the CRS.
Vector first_sample(const cache::Manifest& m) {
  const auto& t = m.geotransform;
  return {t[0] + 0.5 * (t[1] + t[2]), t[3] + 0.5 * (t[4] + t[5])};
}

Map metres_of_crs(const cache::Manifest& m) {
  const codec::TreeLayout& l = m.layout;
  return map_of(column_step(m), row_step(m), l.axes.world(l.dx_m, 0), l.axes.world(0, l.dy_m));
}

codec::TreeLayout lay(const cache::Manifest& m, const Map& metres, const Vector& origin) {
  codec::TreeLayout out = m.layout;
  const Vector column = metres(column_step(m));
  const Vector row = metres(row_step(m));
  out.dx_m = std::hypot(column[0], column[1]);
  out.dy_m = std::hypot(row[0], row[1]);
  out.axes = {{column[0] / out.dx_m, column[1] / out.dx_m}, {row[0] / out.dy_m, row[1] / out.dy_m}};
  const Vector first = first_sample(m);
  out.origin_m = metres({first[0] - origin[0], first[1] - origin[1]});
  return out;
}

/// The extent of a tree in the columns and rows of another, whose own runs from 0 to columns - 1 and rows - 1.
struct Extent {
  Vector low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Vector high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
};

Extent extent_in(const codec::TreeLayout& grid, const codec::TreeLayout& tree) {
  Extent out;
  for (const std::int64_t column : {std::int64_t{0}, tree.columns - 1}) {
    for (const std::int64_t row : {std::int64_t{0}, tree.rows - 1}) {
      const auto [x, y] = tree.world(static_cast<double>(column), static_cast<double>(row));
      const Vector at = grid.grid(x, y);
      for (std::size_t i = 0; i < 2; ++i) {
        out.low[i] = std::min(out.low[i], at[i]);
        out.high[i] = std::max(out.high[i], at[i]);
      }
    }
  }
  return out;
}

/// Sides of `tree` across which `other` goes on; half a sample counts as touching.
std::uint16_t joined_sides(const codec::TreeLayout& tree, const codec::TreeLayout& other) {
  constexpr double kTouch = 0.5;
  const Extent e = extent_in(tree, other);
  const Vector end{static_cast<double>(tree.columns - 1), static_cast<double>(tree.rows - 1)};
  const auto overlaps = [&](std::size_t i) { return e.high[i] > kTouch && e.low[i] < end[i] - kTouch; };
  const auto before = [&](std::size_t i) { return e.low[i] < -kTouch && e.high[i] >= -kTouch; };
  const auto after = [&](std::size_t i) { return e.high[i] > end[i] + kTouch && e.low[i] <= end[i] + kTouch; };
  unsigned sides = 0;
  if (overlaps(1) && before(0)) sides |= cache::kSkirtWest;
  if (overlaps(1) && after(0)) sides |= cache::kSkirtEast;
  if (overlaps(0) && before(1)) sides |= cache::kSkirtNorth;
  if (overlaps(0) && after(1)) sides |= cache::kSkirtSouth;
  return static_cast<std::uint16_t>(sides);
}

}  // namespace

Expected<std::vector<PlacedTree>> place_trees(std::span<const TreeToPlace> trees) {
  std::vector<PlacedTree> out;
  if (trees.empty()) return out;
  const cache::Manifest& first = *trees.front().manifest;
  out.push_back({first.layout, 0});
  for (const TreeToPlace& tree : trees.subspan(1)) {
    if (tree.manifest->crs_wkt != first.crs_wkt) {
      return fail(ErrorCode::kBadData,
                  "its CRS is not that of " + trees.front().path +
                      "; to show both in one scene build it again from a DEM in that CRS (gdalwarp -t_srs)",
                  tree.path);
    }
    out.push_back({lay(*tree.manifest, metres_of_crs(first), first_sample(first)), 0});
  }
  for (PlacedTree& tree : out) {
    for (const PlacedTree& other : out) {
      if (&other == &tree) continue;
      tree.joined_sides = static_cast<std::uint16_t>(tree.joined_sides | joined_sides(tree.layout, other.layout));
    }
  }
  return out;
}

}  // namespace tintree::render
