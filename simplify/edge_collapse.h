#pragma once

#include <cstdint>
#include <vector>

#include "simplify/half_edge_mesh.h"
#include "simplify/quadric.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {

/// The lattice that vertices lie on and the bound that the mesh has to keep.
struct CollapseSpec {
  /// The line of a border ribbon, which runs through the middle of its mesh: x = 0 or y = 0; absent in a tile.
  /// It has a bound of its own.
  enum class Line { kAbsent, kX, kY };

  double bound_m = 0;  ///< Largest vertical distance to the surface, guard already taken off.
  Line line = Line::kAbsent;
  double line_bound_m = 0;  ///< The same along that line.
  double z_step_m = 0;      ///< Height of one z step; height 0 is z = 0.
  int sub_bits = 0;         ///< x and y count 2^-sub_bits samples.
  double area_unit = 1;     ///< Area in cells that the quadrics' weights count as one.
};

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
/// is not tried again until its surroundings change.
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
    LatticeVertex position;  // z unused
  };
  struct OuterEdge {
    std::int32_t from;
    std::int32_t to;
  };

  void init_quadrics();
  std::int64_t sweep(double threshold);
  void collect_candidates(std::int32_t vertex, double threshold);
  bool propose(Candidate& candidate) const;
  bool try_collapse(const Candidate& candidate);
  void gather_star(const Candidate& candidate);
  void append_star(std::int32_t vertex, std::int32_t other);
  bool link_is_simple(const Candidate& candidate);
  bool fit_height(const Candidate& candidate, LatticeVertex& position);
  bool on_line(const LatticeVertex& v) const;
  bool follows_outline(std::int32_t slider, std::int32_t other) const;
  Point point(const LatticeVertex& v) const;
  Point point(std::int32_t vertex) const { return point(mesh_->vertices[static_cast<std::size_t>(vertex)]); }
  VertexKind kind(std::int32_t vertex) const { return mesh_->kinds[static_cast<std::size_t>(vertex)]; }
  void forgive_around(std::int32_t vertex);

  HalfEdgeMesh* mesh_ = nullptr;
  SurfaceDistance* distance_ = nullptr;
  CollapseSpec spec_;
  std::vector<CollapseStep>* log_ = nullptr;
  double lattice_ = 1;  // samples per lattice step

  std::vector<Quadric> quadrics_;
  std::vector<double> failed_cost_;  // all candidates up to this cost are known to fail
  std::vector<std::int32_t> mark_;
  std::int32_t mark_value_ = 0;
  std::vector<Candidate> candidates_;
  std::vector<OuterEdge> outer_;
  std::vector<std::int32_t> spokes_;
  Star star_;
};

}  // namespace tintree::simplify
