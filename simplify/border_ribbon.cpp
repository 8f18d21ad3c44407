#include "simplify/border_ribbon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace tintree::simplify {
namespace {

/// A sample of the band: u along the side, v across it (-1, 0 or 1; positive is east or south).
struct BandPoint {
  std::int64_t u;
  std::int64_t v;
};

/// Collects the band's triangles over its samples.
class Band {
 public:
  Band(SurfaceView& view, const Side& side, const HeightLattice& heights)
      : view_(&view), side_(side), heights_(heights), ids_(3 * (static_cast<std::size_t>(side.cells) + 1), kNone) {}

  /// Adds a triangle if all its samples exist, turned counter-clockwise.
  void add(BandPoint a, BandPoint b, BandPoint c) {
    std::array<std::int32_t, 3> t{vertex(a), vertex(b), vertex(c)};
    if (t[0] == kNone || t[1] == kNone || t[2] == kNone) return;
    const std::int64_t turn = (c.u - a.u) * (b.v - a.v) - (b.u - a.u) * (c.v - a.v);
    // With u eastward and v southward this is the doubled area from above; the other way round its mirror.
    if ((turn > 0) == side_.southward) std::swap(t[1], t[2]);
    triangles.push_back(t);
  }

  std::int32_t find(BandPoint p) const { return ids_[slot(p)]; }

  std::vector<LatticeVertex> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;

 private:
  static std::size_t slot(BandPoint p) { return static_cast<std::size_t>(3 * p.u + p.v + 1); }

  std::int32_t vertex(BandPoint p) {
    std::int32_t& id = ids_[slot(p)];
    if (id == kNone) {
      const std::int64_t x = side_.southward ? p.v : p.u;
      const std::int64_t y = side_.southward ? p.u : p.v;
      const double h = view_->sample(side_.column + x, side_.row + y);
      if (std::isnan(h)) return kNone;
      id = static_cast<std::int32_t>(vertices.size());
      vertices.push_back({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), heights_.snap(h)});
    }
    return id;
  }

  SurfaceView* view_;
  Side side_;
  HeightLattice heights_;
  std::vector<std::int32_t> ids_;
};

/// Whether any triangle of the surface lies in the cell.
bool holds_surface(SurfaceView& view, std::int64_t column, std::int64_t row) {
  const bool diagonal = !std::isnan(view.sample(column, row) + view.sample(column + 1, row + 1));
  return diagonal && !(std::isnan(view.sample(column + 1, row)) && std::isnan(view.sample(column, row + 1)));
}

}  // namespace

bool may_flip(SurfaceView& view, std::int64_t column, std::int64_t row, double bound_m, const HeightLattice& heights) {
  const double nw = view.sample(column, row);
  const double ne = view.sample(column + 1, row);
  const double sw = view.sample(column, row + 1);
  const double se = view.sample(column + 1, row + 1);
  // A missing sample makes the difference NaN and the answer no; snap() must not see it.
  if (std::isnan(nw + ne + sw + se)) return false;
  const double tested = tested_bound_m(view.surface(), {column, row, column + 1, row + 1}, bound_m);
  return std::abs((heights.snapped_m(ne) + heights.snapped_m(sw)) / 2 - (nw + se) / 2) <= tested;
}

void BorderRibbon::build(SurfaceView& view, const Side& side, double bound_m, const HeightLattice& heights) {
  const std::int64_t n = side.cells;
  Band band(view, side, heights);
  held_.assign(static_cast<std::size_t>(n) + 1, 0);
  held_.front() = held_.back() = 1;
  for (std::int64_t u = 0; u < n; ++u) {
    for (const std::int64_t v : {std::int64_t{-1}, std::int64_t{0}}) {
      // The cell's samples; the surface's diagonal joins p00 and p11 (transposing a cell keeps it).
      const BandPoint p00{u, v};
      const BandPoint p10{u + 1, v};
      const BandPoint p01{u, v + 1};
      const BandPoint p11{u + 1, v + 1};
      const bool first = u == 0;
      const bool last = u == n - 1;
      if (!first && !last) {
        band.add(p00, p10, p11);
        band.add(p00, p01, p11);
        continue;
      }
      // Cut towards the corner: of this cell the ribbon has the half at the line.
      const bool own_diagonal = first == (v == 0);
      if (own_diagonal) {
        if (v == 0)
          band.add(p00, p10, p11);
        else
          band.add(p00, p01, p11);
        continue;
      }
      const std::int64_t column = side.column + (side.southward ? v : u);
      const std::int64_t row = side.row + (side.southward ? u : v);
      if (may_flip(view, column, row, bound_m, heights)) {
        if (v == 0)
          band.add(p00, p10, p01);
        else
          band.add(p01, p11, p10);
      } else if (holds_surface(view, column, row)) {
        held_[static_cast<std::size_t>(first ? 1 : n - 1)] = 1;
      }
    }
  }
  line_.resize(static_cast<std::size_t>(n) + 1);
  for (std::int64_t u = 0; u <= n; ++u) line_[static_cast<std::size_t>(u)] = band.find({u, 0});
  const std::size_t samples = band.vertices.size();
  mesh_.build(std::move(band.vertices), band.triangles);
  // Where two fans touch on the line the vertex belongs to more than this ribbon can see.
  for (std::size_t i = samples; i < mesh_.vertices.size(); ++i) {
    const LatticeVertex& p = mesh_.vertices[i];
    if ((side.southward ? p.x : p.y) == 0) held_[static_cast<std::size_t>(side.southward ? p.y : p.x)] = 1;
  }
  classify(side);
}

/// Line vertices slide if each side of the line has either the whole half of their star or nothing of it.
void BorderRibbon::classify(const Side& side) {
  std::ranges::fill(mesh_.kinds, VertexKind::kLocked);
  const auto on_line = [&](std::int32_t v) {
    const LatticeVertex& p = mesh_.vertices[static_cast<std::size_t>(v)];
    return (side.southward ? p.x : p.y) == 0;
  };
  for (std::size_t u = 1; u + 1 < line_.size(); ++u) {
    const std::int32_t v = line_[u];
    if (v == kNone || held_[u] != 0 || !mesh_.alive(v)) continue;
    const std::int32_t start = mesh_.outgoing(v);
    int along = 0;
    bool last_along = false;
    for (std::int32_t h = start; h != kNone;) {
      along += on_line(mesh_.target(h)) ? 1 : 0;
      const std::int32_t following = mesh_.rotate(h);
      if (following == kNone) last_along = on_line(mesh_.origin(HalfEdgeMesh::previous(h)));
      h = following == start ? kNone : following;
    }
    const bool whole = !mesh_.on_outline(v) && along == 2;
    const bool half = mesh_.on_outline(v) && along == 1 && on_line(mesh_.target(start)) && last_along;
    if (whole || half) mesh_.kinds[static_cast<std::size_t>(v)] = VertexKind::kSlide;
  }
}

std::vector<RibbonStep> BorderRibbon::settle(SurfaceView& view, const Side& side, double bound_m,
                                             const HeightLattice& heights) {
  build(view, side, bound_m, heights);
  CollapseSpec spec;
  const std::int64_t across = side.southward ? 0 : side.cells;
  const std::int64_t down = side.southward ? side.cells : 0;
  spec.bound_m =
      tested_bound_m(view.surface(), {side.column, side.row, side.column + across, side.row + down}, bound_m);
  spec.line = side.southward ? CollapseSpec::Line::kX : CollapseSpec::Line::kY;
  spec.line_bound_m = spec.bound_m / 2;
  spec.z_step_m = heights.step_m;
  std::vector<CollapseStep> log;
  // The collapse merges line vertices by their place in mesh order; what a tile needs is the sample and the
  // direction.
  SurfaceDistance distance(view, side.column, side.row);
  const auto along = [&](std::int32_t v) {
    const LatticeVertex& p = mesh_.vertices[static_cast<std::size_t>(v)];
    return side.southward ? p.y : p.x;
  };
  collapse_.run(mesh_, distance, spec, &log);
  std::vector<RibbonStep> steps;
  steps.reserve(log.size());
  for (const CollapseStep& s : log)
    steps.push_back({along(s.gone), along(s.kept) > along(s.gone) ? 1 : -1, s.position.z});
  return steps;
}

}  // namespace tintree::simplify
