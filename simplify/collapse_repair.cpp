#include "simplify/collapse_repair.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tintree::simplify {
namespace {

// Largest errors of a star (docs/performance.md, What was tried).
constexpr int kShareParts = 16;           ///< Shares of the bound are counted in these.
constexpr int kWhole = kShareParts;       ///< What a star has to keep in the end.
constexpr int kRelaxed = kWhole * 3 / 2;  ///< Collapses further beyond the bound are not tried.
constexpr int kWorthIt = kWhole * 9 / 8;  ///< Neighbours are moved only where the merged vertex comes so near alone.
constexpr int kEnough = kWhole * 7 / 8;   ///< Neighbours are not moved to fit better than this.

double as_double(int share) { return static_cast<double>(share) / kShareParts; }

}  // namespace

void CollapseRepair::put(std::int32_t vertex, const LatticeVertex& place) {
  LatticeVertex& v = mesh_->vertex(vertex);
  journal_.push_back({vertex, v});
  v = place;
}

/// Moves a hub `there` if its star then keeps a smaller share of the bound, as small as it gets.
bool CollapseRepair::try_lower(LatticeVertex& place, const LatticeVertex& there, const Ring& ring, int& share,
                               int enough) {
  if (share <= enough || !fit_->unfolded(there, ring)) return false;
  const int before = share;
  int least = enough;  // no less can be kept there, or need be
  for (int next = share - 1; least < share;) {
    const HeightRange range = fit_->heights(there, ring, as_double(next));
    if (range.empty()) {
      least = next + 1;
      next = (least + share) / 2;
    } else {
      share = next;
      place = {there.x, there.y, range.lowest + (range.highest - range.lowest) / 2};
      least = std::max(least, share - static_cast<int>(range.spare * kShareParts));
      next = least;
    }
  }
  return share < before;
}

/// Moves a hub, in height and to neighbouring lattice points, to lower the share of the bound that its star needs,
/// known to be at most `share`.
bool CollapseRepair::lower(LatticeVertex& place, const Ring& ring, int& share, int enough) {
  constexpr int kRounds = 3;
  constexpr std::array<std::array<int, 2>, 8> kDirections{
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};
  bool moved = try_lower(place, LatticeVertex{place}, ring, share, enough);
  const int least = 1 << fit_->spec().coarse_bits;
  // On a lattice finer than the samples larger steps come first.
  for (int step = std::max(1 << fit_->spec().sub_bits, least); step >= least; step /= 2) {
    for (int round = 0; round < kRounds; ++round) {
      bool better = false;
      for (const auto& [dx, dy] : kDirections) {
        const LatticeVertex there{place.x + dx * step, place.y + dy * step, 0};
        better |= try_lower(place, there, ring, share, enough);
      }
      moved |= better;
      if (!better) break;
    }
  }
  return moved;
}

/// The surroundings of a neighbour of the merged vertex, as they will be.
void CollapseRepair::gather(std::int32_t vertex) {
  ring_.clear();
  const auto merges = [this](std::int32_t v) { return v == gone_ || v == kept_; };
  bool met = false;
  const auto spoke = [&](std::int32_t v) {
    // Both ends of the edge are at the merged vertex's place by now: one of them is enough.
    if (merges(v) && std::exchange(met, true)) return;
    ring_.spokes.push_back(v);
  };
  const std::int32_t start = mesh_->outgoing(vertex);
  for (std::int32_t h = start; h != kNone;) {
    const std::int32_t from = mesh_->target(h);
    const std::int32_t to = mesh_->origin(HalfEdgeMesh::previous(h));
    if (!(merges(from) && merges(to))) ring_.sides.push_back({from, to});
    spoke(from);
    const std::int32_t following = mesh_->rotate(h);
    if (following == kNone) spoke(to);
    h = following == start ? kNone : following;
  }
}

bool CollapseRepair::search(const Ring& ring, LatticeVertex& merged) {
  const auto place_merged = [&] { mesh_->vertex(gone_) = mesh_->vertex(kept_) = merged; };
  int share = kRelaxed;
  lower(merged, ring, share, kWhole);
  place_merged();
  if (share > kWorthIt) return false;
  if (share > kWhole) {
    for (const std::int32_t neighbour : ring.spokes) {
      if (mesh_->kinds[static_cast<std::size_t>(neighbour)] != VertexKind::kFree) continue;
      gather(neighbour);
      LatticeVertex place = mesh_->vertex(neighbour);
      int own = share;
      if (!lower(place, ring_, own, kEnough)) continue;
      put(neighbour, place);
      moved_.push_back(neighbour);
    }
    share = kRelaxed;
    lower(merged, ring, share, kWhole);
    place_merged();
  }
  if (share > kWhole) return false;
  return std::ranges::all_of(moved_, [this](std::int32_t neighbour) {
    gather(neighbour);
    return fit_->keeps(mesh_->vertex(neighbour), ring_);
  });
}

bool CollapseRepair::run(HalfEdgeMesh& mesh, StarFit& fit, std::int32_t gone, std::int32_t kept, const Ring& ring,
                         LatticeVertex& merged) {
  mesh_ = &mesh;
  fit_ = &fit;
  gone_ = gone;
  kept_ = kept;
  journal_.clear();
  moved_.clear();
  if (!fit.unfolded(merged, ring)) return false;
  const HeightRange range = fit.heights(merged, ring, as_double(kRelaxed));
  if (range.empty()) return false;
  merged.z = range.lowest + (range.highest - range.lowest) / 2;
  put(gone, merged);
  put(kept, merged);
  if (search(ring, merged)) return true;
  while (!journal_.empty()) {
    mesh.vertex(journal_.back().vertex) = journal_.back().before;
    journal_.pop_back();
  }
  return false;
}

}  // namespace tintree::simplify
