#include "simplify/border_ribbon.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "simplify/surface_distance.h"

namespace tintree::simplify {

/// Line vertices slide if each side of the line has either the whole half of their star or nothing of it.
bool BorderRibbon::may_slide(std::int32_t vertex, const Side& side) const {
  const auto on_line = [&](std::int32_t v) { return side.across(mesh_.vertices[static_cast<std::size_t>(v)]) == 0; };
  const std::int32_t start = mesh_.outgoing(vertex);
  int along = 0;
  bool last_along = false;
  for (std::int32_t h = start; h != kNone;) {
    along += on_line(mesh_.target(h)) ? 1 : 0;
    const std::int32_t following = mesh_.rotate(h);
    if (following == kNone) last_along = on_line(mesh_.origin(HalfEdgeMesh::previous(h)));
    h = following == start ? kNone : following;
  }
  if (!mesh_.on_outline(vertex)) return along == 2;
  return along == 1 && on_line(mesh_.target(start)) && last_along;
}

void BorderRibbon::build(RightTriangleMesh& start, const Side& side) {
  std::array<bool, 2> open_ends{};
  StartMesh band = start.band(side, open_ends);
  const std::size_t samples = band.vertices.size();
  mesh_.build(std::move(band.vertices), band.triangles);
  std::ranges::fill(mesh_.kinds, VertexKind::kLocked);
  // Where two fans touch on the line the vertex belongs to more than this ribbon can see.
  std::vector<std::int32_t> held;
  if (open_ends[0]) held.push_back(1);
  if (open_ends[1]) held.push_back(static_cast<std::int32_t>(side.cells) - 1);
  for (std::size_t i = samples; i < mesh_.vertices.size(); ++i) {
    if (side.across(mesh_.vertices[i]) == 0) held.push_back(side.along(mesh_.vertices[i]));
  }
  for (std::size_t i = 0; i < samples; ++i) {
    const LatticeVertex& p = mesh_.vertices[i];
    const std::int32_t u = side.along(p);
    const auto v = static_cast<std::int32_t>(i);
    if (side.across(p) != 0 || u == 0 || u == side.cells || !mesh_.alive(v)) continue;
    if (std::ranges::find(held, u) == held.end() && may_slide(v, side)) mesh_.kinds[i] = VertexKind::kSlide;
  }
}

std::vector<RibbonStep> BorderRibbon::settle(SurfaceView& view, RightTriangleMesh& start, const Side& side,
                                             const LevelGrid& level) {
  build(start, side);
  CollapseSpec spec;
  const std::int64_t across = side.southward ? 0 : side.cells;
  const std::int64_t down = side.southward ? side.cells : 0;
  // The band reaches one square to either side.
  const std::int64_t reach_x = side.southward ? level.square() : 0;
  const std::int64_t reach_y = side.southward ? 0 : level.square();
  spec.bound_m = tested_bound_m(
      view.surface(),
      {side.column - reach_x, side.row - reach_y, side.column + across + reach_x, side.row + down + reach_y},
      level.bound_m);
  spec.line = side.southward ? CollapseSpec::Line::kX : CollapseSpec::Line::kY;
  spec.line_bound_m = spec.bound_m / 2;
  spec.z_step_m = level.heights.step_m;
  std::vector<CollapseStep> log;
  SurfaceDistance distance(view, side.column, side.row);
  // What a tile needs of each collapse is the sample and the direction.
  const auto along = [&](std::int32_t v) { return side.along(mesh_.vertices[static_cast<std::size_t>(v)]); };
  collapse_.run(mesh_, distance, spec, &log);
  std::vector<RibbonStep> steps;
  steps.reserve(log.size());
  for (const CollapseStep& s : log)
    steps.push_back({along(s.gone), along(s.kept) > along(s.gone) ? 1 : -1, s.position.z});
  return steps;
}

}  // namespace tintree::simplify
