#include "simplify/edge_collapse.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tintree::simplify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Cost thresholds of the passes, in squared bounds times area units.
constexpr double kPassThresholds[] = {1e-3, 0.256, 65.536, kInfinity};
/// The last pass is repeated until fewer than one in this many live vertices collapse.
constexpr std::int64_t kSettled = 100;
/// Sweeps that repair; in all but the first, what changed in the one before is tried again.
constexpr int kRepairSweeps = 2;
/// Mean squared distance of the planes from the merged vertex, in squared bounds, beyond which hardly any collapse
/// keeps the bound (docs/performance.md).
constexpr double kHopeless = 2;
constexpr double kHopelessToRepair = 4;
/// Rounding of a cost, relative to the terms that it is the difference of.
constexpr double kCostRounding = 1e-14;
/// Height error, in bounds, that a vertex may trade for staying near the middle of its edge.
constexpr double kRidge = 0.05;
/// How often a sweep looks whether it has been interrupted.
constexpr std::int32_t kVerticesPerLook = 256;

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

std::int64_t cross(const LatticeVertex& a, const LatticeVertex& b, const LatticeVertex& c, const LatticeVertex& d) {
  return std::int64_t{b.x - a.x} * (d.y - c.y) - std::int64_t{b.y - a.y} * (d.x - c.x);
}

}  // namespace

void EdgeCollapse::run(HalfEdgeMesh& mesh, SurfaceDistance& distance, const CollapseSpec& spec,
                       std::vector<CollapseStep>* log) {
  mesh_ = &mesh;
  spec_ = spec;
  fit_.emplace(mesh, distance, spec);
  log_ = log;
  init_quadrics();
  failed_cost_.assign(mesh.vertices.size(), -1);
  mark_.assign(mesh.vertices.size(), 0);
  mark_value_ = 0;
  std::int64_t live = 0;
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) live += mesh.alive(v) ? 1 : 0;
  const double unit = spec.bound_m * spec.bound_m;
  for (const double threshold : kPassThresholds) {
    std::int64_t gone = 0;
    do {
      gone = sweep(threshold * unit, false);
      live -= gone;
    } while (threshold == kInfinity && gone * kSettled > live);
  }
  if (spec.effort == Effort::kBest) {
    std::ranges::fill(failed_cost_, -1);
    for (int i = 0; i < kRepairSweeps; ++i) sweep(kInfinity, true);
  }
}

/// The start mesh's vertices lie at samples. Its triangles count as they would at the samples' own heights: rounded to
/// the lattice, those of a cell or two would point anywhere.
void EdgeCollapse::init_quadrics() {
  quadrics_.assign(mesh_->vertices.size(), {});
  for (std::int32_t h = 0; h < mesh_->half_edge_count(); h += 3) {
    if (!mesh_->triangle_alive(h)) continue;
    const std::int32_t corners[3] = {mesh_->origin(h), mesh_->origin(h + 1), mesh_->origin(h + 2)};
    const Point p = fit_->on_surface(mesh_->vertex(corners[0]));
    const Point q = fit_->on_surface(mesh_->vertex(corners[1]));
    const Point r = fit_->on_surface(mesh_->vertex(corners[2]));
    const double d = (q.x - p.x) * (r.y - p.y) - (r.x - p.x) * (q.y - p.y);
    const double a = ((q.z - p.z) * (r.y - p.y) - (r.z - p.z) * (q.y - p.y)) / d;
    const double b = ((q.x - p.x) * (r.z - p.z) - (r.x - p.x) * (q.z - p.z)) / d;
    const Quadric quadric = Quadric::of_plane(a, b, p.z - a * p.x - b * p.y, std::abs(d) / 6 / spec_.area_unit);
    for (const std::int32_t v : corners) quadrics_[at(v)] += quadric;
  }
}

std::int64_t EdgeCollapse::sweep(double threshold, bool repair) {
  std::int64_t gone = 0;
  for (std::int32_t v = 0; v < mesh_->vertex_count(); ++v) {
    if (v % kVerticesPerLook == 0 && fit_->interrupted()) return 0;
    if (!mesh_->alive(v) || kind(v) > VertexKind::kSlide || failed_cost_[at(v)] >= threshold) continue;
    collect_candidates(v, threshold);
    if (collapse_any(repair))
      ++gone;
    else
      failed_cost_[at(v)] = untried_cost_;
  }
  return gone;
}

/// Carries out the first of the candidates that keeps the bound.
bool EdgeCollapse::collapse_any(bool repair) {
  return std::ranges::any_of(candidates_, [&](const Candidate& candidate) {
    if (try_collapse(candidate)) return true;
    if (kind(candidate.kept) != VertexKind::kFree) return false;
    Candidate staying = candidate;
    staying.position = mesh_->vertex(candidate.kept);
    const bool same = staying.position.x == candidate.position.x && staying.position.y == candidate.position.y;
    return (!same && try_collapse(staying)) || (repair && try_repair(candidate));
  });
}

void EdgeCollapse::collect_candidates(std::int32_t vertex, double threshold) {
  candidates_.clear();
  untried_cost_ = kInfinity;
  const auto consider = [&](std::int32_t half_edge, std::int32_t other) {
    Candidate candidate{half_edge, vertex, other, 0, {}};
    if (!propose(candidate) || candidate.cost < failed_cost_[at(vertex)]) return;
    if (candidate.cost > threshold) {
      untried_cost_ = std::min(untried_cost_, candidate.cost);
      return;
    }
    // Two free ends propose the same collapse: what failed from the other end fails from here.
    if (kind(other) == VertexKind::kFree && kind(vertex) == VertexKind::kFree &&
        candidate.cost < failed_cost_[at(other)])
      return;
    candidates_.push_back(candidate);
  };
  const std::int32_t start = mesh_->outgoing(vertex);
  for (std::int32_t h = start; h != kNone;) {
    consider(h, mesh_->target(h));
    const std::int32_t following = mesh_->rotate(h);
    if (following == kNone) consider(HalfEdgeMesh::previous(h), mesh_->origin(HalfEdgeMesh::previous(h)));
    h = following == start ? kNone : following;
  }
  std::ranges::sort(candidates_, [](const Candidate& a, const Candidate& b) {
    return a.cost != b.cost ? a.cost < b.cost : a.half_edge < b.half_edge;
  });
}

/// Where the merged vertex would go and what that costs; false when the two kinds cannot merge, or surely too far
/// from the surface.
bool EdgeCollapse::propose(Candidate& candidate) const {
  const LatticeVertex& from = mesh_->vertices[at(candidate.gone)];
  const LatticeVertex& to = mesh_->vertices[at(candidate.kept)];
  const VertexKind kept_kind = kind(candidate.kept);
  if (kind(candidate.gone) == VertexKind::kSlide &&
      (kept_kind == VertexKind::kFree || !follows_outline(candidate.gone, candidate.kept))) {
    return false;
  }
  Quadric sum = quadrics_[at(candidate.gone)];
  sum += quadrics_[at(candidate.kept)];
  const Quadric::Plan plan = sum.plan();
  candidate.position = to;
  if (kept_kind == VertexKind::kFree) {
    const double mx = (from.x + to.x) * fit_->lattice() / 2;
    const double my = (from.y + to.y) * fit_->lattice() / 2;
    const double ex = (to.x - from.x) * fit_->lattice();
    const double ey = (to.y - from.y) * fit_->lattice();
    const double ridge = sum.zz * kRidge * kRidge * spec_.bound_m * spec_.bound_m / (ex * ex + ey * ey);
    double px = 0;
    double py = 0;
    plan.minimise(mx, my, ridge, px, py);
    // Far outside, the new triangles would fold: no need to look.
    const double reach = 4 * (std::abs(ex) + std::abs(ey)) + 4;
    if (!(std::abs(px - mx) < reach) || !(std::abs(py - my) < reach)) {
      px = mx;
      py = my;
    }
    const int coarse = spec_.coarse_bits;
    const double step = std::ldexp(fit_->lattice(), coarse);
    candidate.position.x = static_cast<std::int32_t>(std::lround(px / step)) << coarse;
    candidate.position.y = static_cast<std::int32_t>(std::lround(py / step)) << coarse;
  }
  const double px = candidate.position.x * fit_->lattice();
  const double py = candidate.position.y * fit_->lattice();
  candidate.cost = plan.at(px, py);
  if (kept_kind == VertexKind::kLocked) {
    const double off = to.z * spec_.heights.step_m - sum.best_height(px, py);
    candidate.cost += sum.zz * off * off;
  }
  candidate.cost = std::max(candidate.cost, 0.0);
  const double hopeless = spec_.effort == Effort::kBest ? kHopelessToRepair : kHopeless;
  // Where the bound is tiny beside the heights all costs are rounding. A cost that is no number is refused.
  const double rounding = kCostRounding * (sum.one + sum.xx * px * px + sum.yy * py * py);
  return candidate.cost <= hopeless * sum.zz * spec_.bound_m * spec_.bound_m + rounding;
}

/// Whether `other` lies on the straight line that `slider` slides along.
bool EdgeCollapse::follows_outline(std::int32_t slider, std::int32_t other) const {
  const LatticeVertex& here = mesh_->vertices[at(slider)];
  const LatticeVertex& there = mesh_->vertices[at(other)];
  if (spec_.line != CollapseSpec::Line::kAbsent) return spec_.on_line(here) && spec_.on_line(there);
  const LatticeVertex& ahead = mesh_->vertices[at(mesh_->target(mesh_->outgoing(slider)))];
  return cross(here, ahead, here, there) == 0;
}

/// Collects the outer edges and the spokes of the star that the collapse would leave. The own triangles of
/// a hub that stays as it is do not change and are left out.
void EdgeCollapse::gather_star(const Candidate& candidate) {
  ring_.clear();
  append_star(candidate.gone, candidate.kept);
  const bool hub_stays = kind(candidate.kept) == VertexKind::kLocked;
  if (!hub_stays) append_star(candidate.kept, candidate.gone);
  // Each corner of the ring starts one outer edge, except the last of an open fan.
  ++mark_value_;
  for (const Ring::Side& e : ring_.sides) {
    ring_.spokes.push_back(e.from);
    mark_[at(e.from)] = mark_value_;
  }
  for (const Ring::Side& e : ring_.sides) {
    if (mark_[at(e.to)] != mark_value_) ring_.spokes.push_back(e.to);
  }
  if (hub_stays) {
    // The apexes are joined to the hub already.
    const std::int32_t h = candidate.half_edge;
    std::erase(ring_.spokes, mesh_->origin(HalfEdgeMesh::previous(h)));
    if (mesh_->twin(h) != kNone) std::erase(ring_.spokes, mesh_->origin(HalfEdgeMesh::previous(mesh_->twin(h))));
  }
}

/// Appends the outer edges of those triangles of `vertex` that do not hold `other`.
void EdgeCollapse::append_star(std::int32_t vertex, std::int32_t other) {
  const std::int32_t start = mesh_->outgoing(vertex);
  for (std::int32_t h = start; h != kNone;) {
    const std::int32_t from = mesh_->target(h);
    const std::int32_t to = mesh_->origin(HalfEdgeMesh::previous(h));
    if (from != other && to != other) ring_.sides.push_back({from, to});
    const std::int32_t following = mesh_->rotate(h);
    h = following == start ? kNone : following;
  }
}

/// The link condition: the two ends share exactly the apexes of the edge's own triangles.
bool EdgeCollapse::link_is_simple(const Candidate& candidate) {
  const bool inside = mesh_->twin(candidate.half_edge) != kNone;
  // Two outlines must not be pinched together across the mesh.
  if (inside && mesh_->on_outline(candidate.gone) && mesh_->on_outline(candidate.kept)) return false;
  ++mark_value_;
  const auto visit = [&](std::int32_t v, const auto& f) {
    const std::int32_t start = mesh_->outgoing(v);
    for (std::int32_t h = start; h != kNone;) {
      f(mesh_->target(h));
      const std::int32_t following = mesh_->rotate(h);
      if (following == kNone) f(mesh_->origin(HalfEdgeMesh::previous(h)));
      h = following == start ? kNone : following;
    }
  };
  visit(candidate.gone, [&](std::int32_t n) { mark_[at(n)] = mark_value_; });
  int shared = 0;
  visit(candidate.kept, [&](std::int32_t n) { shared += mark_[at(n)] == mark_value_ ? 1 : 0; });
  return shared == (inside ? 2 : 1);
}

/// Chooses the height of the merged vertex that costs least of those that keep the bound; false when there is none.
bool EdgeCollapse::fit_height(Candidate& candidate) {
  if (kind(candidate.kept) == VertexKind::kLocked) return fit_->keeps(candidate.position, ring_);
  const HeightRange range = fit_->heights(candidate.position, ring_);
  if (range.empty()) return false;
  Quadric sum = quadrics_[at(candidate.gone)];
  sum += quadrics_[at(candidate.kept)];
  const Point place = fit_->point(candidate.position);
  const double wished = std::round(sum.best_height(place.x, place.y) / spec_.heights.step_m);
  candidate.position.z = static_cast<std::int32_t>(std::clamp<double>(wished, range.lowest, range.highest));
  return true;
}

bool EdgeCollapse::try_collapse(Candidate candidate) {
  gather_star(candidate);
  if (ring_.sides.empty() || !fit_->unfolded(candidate.position, ring_)) return false;
  if (!link_is_simple(candidate) || !fit_height(candidate)) return false;
  merge(candidate, candidate.position);
  return true;
}

/// The same, if need be with neighbours moved out of the way.
bool EdgeCollapse::try_repair(const Candidate& candidate) {
  if (kind(candidate.gone) != VertexKind::kFree) return false;
  gather_star(candidate);
  LatticeVertex merged = candidate.position;
  if (ring_.sides.empty() || !link_is_simple(candidate)) return false;
  if (!repair_.run(*mesh_, *fit_, candidate.gone, candidate.kept, ring_, merged)) return false;
  merge(candidate, merged);
  for (const std::int32_t v : repair_.moved()) forgive_around(v);
  return true;
}

void EdgeCollapse::merge(const Candidate& candidate, const LatticeVertex& position) {
  quadrics_[at(candidate.kept)] += quadrics_[at(candidate.gone)];
  mesh_->collapse(candidate.half_edge, candidate.kept);
  mesh_->vertex(candidate.kept) = position;
  if (log_ != nullptr) log_->push_back({candidate.gone, candidate.kept, position});
  forgive_around(candidate.kept);
}

/// What failed around a changed vertex may succeed now.
void EdgeCollapse::forgive_around(std::int32_t vertex) {
  failed_cost_[at(vertex)] = -1;
  const std::int32_t start = mesh_->outgoing(vertex);
  for (std::int32_t h = start; h != kNone;) {
    failed_cost_[at(mesh_->target(h))] = -1;
    const std::int32_t following = mesh_->rotate(h);
    if (following == kNone) failed_cost_[at(mesh_->origin(HalfEdgeMesh::previous(h)))] = -1;
    h = following == start ? kNone : following;
  }
}

}  // namespace tintree::simplify
