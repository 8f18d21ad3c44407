#pragma once

#include <cstdint>
#include <vector>

#include "simplify/collapse_spec.h"
#include "simplify/half_edge_mesh.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {

/// What surrounds a vertex: the sides of its triangles opposite to it, and the far ends of its edges.
struct Ring {
  struct Side {
    std::int32_t from;
    std::int32_t to;
  };
  std::vector<Side> sides;
  std::vector<std::int32_t> spokes;

  void clear() {
    sides.clear();
    spokes.clear();
  }
};

/// Heights on the lattice, both ends included; empty when lowest > highest.
struct HeightRange {
  std::int32_t lowest = 0;
  std::int32_t highest = -1;
  /// A share of the bounds that is smaller by more than this leaves no height.
  double spare = 0;

  bool empty() const { return lowest > highest; }
};

/// Fits vertices of a mesh on the lattice to the surface: which heights does the bound allow the hub of a star at a
/// given place? What is tested is what will be stored. Not thread-safe.
class StarFit {
 public:
  StarFit(const HalfEdgeMesh& mesh, SurfaceDistance& distance, const CollapseSpec& spec);

  const CollapseSpec& spec() const { return spec_; }
  bool interrupted() const { return distance_->interrupted(); }  ///< SurfaceView::interrupted().
  double lattice() const { return lattice_; }                    ///< Samples per lattice step.
  /// The place of a vertex in samples and metres.
  Point point(const LatticeVertex& v) const { return {v.x * lattice_, v.y * lattice_, spec_.heights.height_m(v.z)}; }
  /// The place of the surface above or below a vertex; its height counts from the lattice's origin.
  Point on_surface(const LatticeVertex& v) const {
    const double height_m = distance_->surface().height_at(v.x * lattice_, v.y * lattice_);
    return {v.x * lattice_, v.y * lattice_, height_m - spec_.heights.height_m(0)};
  }

  /// Whether all triangles of a star with its hub at this place are counter-clockwise seen from above.
  bool unfolded(const LatticeVertex& hub, const Ring& ring) const;
  /// The heights of the hub, at its x and y, that keep its star within `share` of the bounds.
  HeightRange heights(const LatticeVertex& hub, const Ring& ring, double share = 1);
  /// Whether the star keeps the bounds with its hub just there.
  bool keeps(const LatticeVertex& hub, const Ring& ring);

 private:
  void clip(const Point& hub, bool on_line, const Ring& ring, double share, HeightInterval& interval);

  const HalfEdgeMesh* mesh_;
  SurfaceDistance* distance_;
  CollapseSpec spec_;
  double lattice_;
  Star star_;
};

}  // namespace tintree::simplify
