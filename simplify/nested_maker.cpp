#include "simplify/nested_maker.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

#include "codec/nested_mesh.h"
#include "codec/nested_tile.h"
#include "codec/split_hierarchy.h"
#include "simplify/finish_tile.h"

namespace tintree::simplify {
namespace {

using codec::NestedPoints;
using codec::SplitPoint;

/// Points are in half samples.
constexpr int kSubBits = 1;

/// Whether a corner of the mesh lies where there is no surface.
bool has_gap(const RestrictedQuadtree& tree, SurfaceView& view, std::int64_t column0, std::int64_t row0) {
  bool found = false;
  tree.for_each_vertex(
      [&](const SplitPoint& p) { found = found || std::isnan(quadtree_height_m(view, column0, row0, p)); });
  return found;
}

/// Gaps may lie between the places of vertices.
void refine_addresses(codec::TileMesh& mesh, int finer) {
  for (codec::GridVertex& v : mesh.vertices) v = {v.x << finer, v.y << finer, v.z};
  mesh.xy_shift -= finer;
}

}  // namespace

NestedMaker::NestedMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, const StopFlag* stop)
    : view_(surface, stop), layout_(layout) {}

Expected<codec::TileMesh> NestedMaker::make(const codec::TileId& id) {
  const std::int64_t cells = layout_.cells_across(id.level);
  const auto range = view_.surface().height_range_m(layout_.cells(id));
  if (range[0] > range[1]) return codec::TileMesh{};
  if (2 * cells > std::int64_t{1} << NestedPoints::kMostSideBits) {
    return fail(ErrorCode::kBadData, "the DEM is too large for method nested; choose another --method",
                "tile " + id.text());
  }
  HeightLattice heights{layout_.z_step_m[static_cast<std::size_t>(id.level)]};
  heights.origin = heights.address(range[0]);
  const NestedPoints points =
      collect_points(std::int64_t{id.x} * cells, std::int64_t{id.y} * cells, cells, layout_.bound_m(id.level), heights);
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  codec::TileMesh made = codec::finest_mesh(points);
  made.z_offset = heights.origin;
  auto mesh = finish_tile(std::move(made), 2 * cells, kSubBits, id);
  if (!mesh || mesh->vertices.empty()) return mesh;
  std::uint32_t all_bits = 0;
  for (const codec::NestedGap& g : mesh->nested_gaps) all_bits |= static_cast<std::uint32_t>(g.x | g.y);
  const int shift = mesh->xy_shift + kSubBits;
  const int common = std::min(shift, std::countr_zero(all_bits));
  refine_addresses(*mesh, shift - common);
  for (codec::NestedGap& g : mesh->nested_gaps) g = {g.x >> common, g.y >> common, g.level};
  return mesh;
}

/// Every point that a level splits at, with its height or as a gap.
NestedPoints NestedMaker::collect_points(std::int64_t column0, std::int64_t row0, std::int64_t cells, double bound_m,
                                         const HeightLattice& heights) {
  NestedPoints points(std::countr_zero(static_cast<std::uint64_t>(2 * cells)));
  const auto add = [&](const SplitPoint& p, int level) {
    const double h = quadtree_height_m(view_, column0, row0, p);
    const bool gap = std::isnan(h);
    points.add({static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y), gap ? 0 : heights.snap(h),
                static_cast<std::uint8_t>(level), gap});
  };
  for (std::int32_t i = 0; i < NestedPoints::kBasePoints; ++i) {
    const auto [x, y] = points.base_place(i);
    add({x, y}, 0);
  }
  constexpr int kLevels = codec::NestedTile::kMostLevels;
  const double half_sample_m = std::min(layout_.dx_m, layout_.dy_m) / 2;
  const std::vector<RestrictedQuadtree> trees =
      RestrictedQuadtree::nested(view_, {cells, bound_m, heights}, kLevels, column0, row0);
  const bool stops_early = !has_gap(trees.front(), view_, column0, row0);
  for (int level = 0; level < kLevels && !view_.interrupted(); ++level) {
    const double tolerance_m = std::ldexp(bound_m, kLevels - 1 - level);
    const double least_unit = level == kLevels - 1 || !stops_early ? 0 : tolerance_m / half_sample_m;
    trees[static_cast<std::size_t>(level)].for_each_vertex([&](const SplitPoint& p) {
      const bool known = points.find(static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y)) >= 0;
      if (!known && static_cast<double>(codec::split_unit(p)) >= least_unit) add(p, level);
    });
  }
  return points;
}

}  // namespace tintree::simplify
