#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "simplify/collapse_repair.h"
#include "simplify/collapse_spec.h"
#include "simplify/half_edge_mesh.h"
#include "simplify/quadric.h"
#include "simplify/star_fit.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {

/// One collapse as it was made: `gone` merged into `kept`, which now is at `position`.
struct CollapseStep {
  std::int32_t gone;
  std::int32_t kept;
  LatticeVertex position;
};

/// Simplifies a mesh that keeps the bound into one with fewer vertices that keeps it too, by edge collapse
/// in the order of quadric cost (Wahl et al. 2004, section 6; Garland and Heckbert 1997). Each proposed
/// collapse is checked against the reference surface at every vertex of the overlay and carried out or
/// dropped; the check yields the interval of heights that the kept vertex may take. Instead of a queue the
/// vertices are swept in memory order under a cost threshold that grows from pass to pass, and what failed
/// is not tried again until its surroundings change. With the best effort the last sweeps also try to make room for
/// collapses that break the bound by a little.
///
/// Vertices keep to the lattice, triangles keep their orientation, outlines their shape. Deterministic.
/// Not thread-safe; reuses its memory from run to run.
class EdgeCollapse {
 public:
  /// Appends every collapse to `log` when given. Ends early, with a valid mesh, once the distance's view is
  /// interrupted.
  void run(HalfEdgeMesh& mesh, SurfaceDistance& distance, const CollapseSpec& spec,
           std::vector<CollapseStep>* log = nullptr);

 private:
  struct Candidate {
    std::int32_t half_edge;
    std::int32_t gone;
    std::int32_t kept;
    double cost;
    LatticeVertex position;  ///< z is found last.
  };
  void init_quadrics();
  std::int64_t sweep(double threshold, bool repair);
  bool collapse_any(bool repair);
  void collect_candidates(std::int32_t vertex, double threshold);
  bool propose(Candidate& candidate) const;
  bool try_collapse(Candidate candidate);
  bool try_repair(const Candidate& candidate);
  void merge(const Candidate& candidate, const LatticeVertex& position);
  void gather_star(const Candidate& candidate);
  void append_star(std::int32_t vertex, std::int32_t other);
  bool link_is_simple(const Candidate& candidate);
  bool fit_height(Candidate& candidate);
  bool follows_outline(std::int32_t slider, std::int32_t other) const;
  VertexKind kind(std::int32_t vertex) const { return mesh_->kinds[static_cast<std::size_t>(vertex)]; }
  void forgive_around(std::int32_t vertex);

  HalfEdgeMesh* mesh_ = nullptr;
  CollapseSpec spec_;
  std::optional<StarFit> fit_;
  CollapseRepair repair_;
  std::vector<CollapseStep>* log_ = nullptr;

  std::vector<Quadric> quadrics_;
  std::vector<double> failed_cost_;  // all candidates below this cost are known to fail
  std::vector<std::int32_t> mark_;
  std::int32_t mark_value_ = 0;
  std::vector<Candidate> candidates_;
  double untried_cost_ = 0;  // the least of those beyond the sweep's threshold
  Ring ring_;                // around the vertex that a candidate would leave
};

}  // namespace tintree::simplify
