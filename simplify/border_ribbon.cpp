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

/// Returns the lattice that the heights count on.
HeightLattice BorderRibbon::build(RightTriangleMesh& start, const Side& side) {
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
  return band.heights;
}

/// An edge that leads from a vertex of the line into a notch of the rim and may be flipped; kNone when there is none.
std::int32_t BorderRibbon::find_notch(std::int32_t vertex, const Side& side, StarFit& fit) {
  const auto on_line = [&](std::int32_t v) { return side.across(mesh_.vertex(v)) == 0; };
  const std::int32_t start = mesh_.outgoing(vertex);
  for (std::int32_t h = start; h != kNone;) {
    if (mesh_.twin(h) != kNone) {
      const std::int32_t bottom = mesh_.target(h);
      const std::int32_t left = mesh_.origin(HalfEdgeMesh::previous(h));
      const std::int32_t right = mesh_.origin(HalfEdgeMesh::previous(mesh_.twin(h)));
      // The two triangles as they would be, around one of their new edge's ends.
      ring_.sides.assign({{right, bottom}, {vertex, right}});
      ring_.spokes.assign({right});
      const bool in_rim = !on_line(bottom) && !on_line(left) && !on_line(right);
      if (in_rim && fit.unfolded(mesh_.vertex(left), ring_) && fit.keeps(mesh_.vertex(left), ring_)) return h;
    }
    const std::int32_t following = mesh_.rotate(h);
    h = following == start ? kNone : following;
  }
  return kNone;
}

std::vector<RibbonFlip> BorderRibbon::cut_notches(const Side& side, StarFit& fit) {
  std::vector<RibbonFlip> flips;
  for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) {
    if (!mesh_.alive(v) || mesh_.kinds[static_cast<std::size_t>(v)] != VertexKind::kSlide) continue;
    for (std::int32_t h = find_notch(v, side, fit); h != kNone; h = find_notch(v, side, fit)) {
      flips.push_back({side.along(mesh_.vertex(v)), mesh_.vertex(mesh_.target(h))});
      mesh_.flip(h);
    }
  }
  return flips;
}

RibbonPlan BorderRibbon::settle(SurfaceView& view, RightTriangleMesh& start, const Side& side, const LevelGrid& level) {
  CollapseSpec spec;
  spec.heights = build(start, side);
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
  SurfaceDistance distance(view, side.column, side.row);
  StarFit fit(mesh_, distance, spec);
  RibbonPlan plan{cut_notches(side, fit), {}};
  std::vector<CollapseStep> log;
  // What a tile needs of each collapse is the sample and the direction.
  const auto along = [&](std::int32_t v) { return side.along(mesh_.vertices[static_cast<std::size_t>(v)]); };
  collapse_.run(mesh_, distance, spec, &log);
  plan.steps.reserve(log.size());
  for (const CollapseStep& s : log)
    plan.steps.push_back({along(s.gone), along(s.kept) > along(s.gone) ? 1 : -1, spec.heights.origin + s.position.z});
  return plan;
}

}  // namespace tintree::simplify
