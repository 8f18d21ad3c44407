#include "simplify/star_fit.h"

#include <algorithm>
#include <cmath>

namespace tintree::simplify {
namespace {

/// Twice the signed area, positive counter-clockwise seen from above (y runs southward).
std::int64_t doubled_area(const LatticeVertex& a, const LatticeVertex& b, const LatticeVertex& c) {
  return std::int64_t{c.x - a.x} * (b.y - a.y) - std::int64_t{b.x - a.x} * (c.y - a.y);
}

}  // namespace

StarFit::StarFit(const HalfEdgeMesh& mesh, SurfaceDistance& distance, const CollapseSpec& spec)
    : mesh_(&mesh), distance_(&distance), spec_(spec), lattice_(std::ldexp(1.0, -spec.sub_bits)) {}

bool StarFit::unfolded(const LatticeVertex& hub, const Ring& ring) const {
  return std::ranges::all_of(ring.sides, [&](const Ring::Side& s) {
    return doubled_area(hub, mesh_->vertex(s.from), mesh_->vertex(s.to)) > 0;
  });
}

void StarFit::clip(const Point& hub, bool on_line, const Ring& ring, double share, HeightInterval& interval) {
  star_.hub = hub;
  star_.bound_m = share * spec_.bound_m;
  star_.sides.clear();
  star_.spokes.clear();
  for (const Ring::Side& s : ring.sides) {
    star_.sides.push_back({point(mesh_->vertex(s.from)), point(mesh_->vertex(s.to))});
  }
  for (const std::int32_t s : ring.spokes) {
    const LatticeVertex& end = mesh_->vertex(s);
    const bool along = on_line && spec_.on_line(end);
    star_.spokes.push_back({point(end), share * (along ? spec_.line_bound_m : spec_.bound_m)});
  }
  distance_->clip_star(star_, interval);
}

HeightRange StarFit::heights(const LatticeVertex& hub, const Ring& ring, double share) {
  Point place = point(hub);
  place.z = distance_->surface().height_at(place.x, place.y);
  if (std::isnan(place.z)) return {};
  const bool on_line = spec_.on_line(hub);
  const double reach = share * (on_line ? spec_.line_bound_m : spec_.bound_m);
  HeightInterval interval{-reach, reach};
  clip(place, on_line, ring, share, interval);
  if (interval.empty()) return {};
  const double low = (place.z + interval.lo) / spec_.heights.step_m;
  const double high = (place.z + interval.hi) / spec_.heights.step_m;
  // A lower bound takes as much or more off both ends of the interval.
  const double middle = std::round((low + high) / 2);
  const double least_bound = spec_.line == CollapseSpec::Line::kAbsent ? spec_.bound_m : spec_.line_bound_m;
  const double spare = std::min(middle - low, high - middle) * spec_.heights.step_m / least_bound;
  // Rounded inward: what is stored is what was tested.
  const auto origin = static_cast<double>(spec_.heights.origin);
  return {static_cast<std::int32_t>(std::ceil(low) - origin), static_cast<std::int32_t>(std::floor(high) - origin),
          spare};
}

bool StarFit::keeps(const LatticeVertex& hub, const Ring& ring) {
  const Point place = point(hub);
  const bool on_line = spec_.on_line(hub);
  const double off = distance_->surface().height_at(place.x, place.y) - place.z;
  if (!(std::abs(off) <= (on_line ? spec_.line_bound_m : spec_.bound_m))) return false;
  HeightInterval interval{0, 0};
  clip(place, on_line, ring, 1, interval);
  return !interval.empty();
}

}  // namespace tintree::simplify
