#pragma once

#include <cstdint>
#include <vector>

#include "simplify/edge_collapse.h"
#include "simplify/half_edge_mesh.h"
#include "simplify/level_grid.h"
#include "simplify/reference_surface.h"
#include "simplify/right_triangle_mesh.h"
#include "simplify/star_fit.h"

namespace tintree::simplify {

/// A vertex of a side that goes: sample `index` along the side merges into the next vertex towards the
/// side's start (`towards` -1) or end (+1), which then has height address `z`, in steps from height 0.
struct RibbonStep {
  std::int32_t index;
  std::int32_t towards;
  std::int64_t z;

  friend bool operator==(const RibbonStep&, const RibbonStep&) = default;
};

/// An edge from sample `index` of a side to a vertex off it, at `far` relative to the side's start, that is flipped
/// before any vertex goes: its two triangles then meet along the line between their other corners.
struct RibbonFlip {
  std::int32_t index;
  LatticeVertex far;

  friend bool operator==(const RibbonFlip&, const RibbonFlip&) = default;
};

struct RibbonPlan {
  std::vector<RibbonFlip> flips;  ///< In the order in which they were made, as the steps.
  std::vector<RibbonStep> steps;

  friend bool operator==(const RibbonPlan&, const RibbonPlan&) = default;
};

/// Settles the vertices on the sides of tiles, as a pure function of the samples near each side: both
/// tiles at it compute the same, with no communication, and neither gets stuck (docs/accuracy.md, Borders).
/// The triangles of the level's start mesh that touch the side, cut at 45 degrees towards its two ends, form a
/// band; its line is simplified by the ordinary collapse under the ordinary bound, and half of that along the
/// line; the rim's vertices stay. Where the rim has a notch, whose bottom few points of the line see, an edge across
/// the notch takes the place of the one into it, if it keeps the bound; else the line could not do without a vertex at
/// every notch. A tile begins with its half of that band. Not thread-safe; reuses its memory.
class BorderRibbon {
 public:
  /// The guard taken off the level's bound depends on the side alone, never on the tile that asks.
  RibbonPlan settle(SurfaceView& view, RightTriangleMesh& start, const Side& side, const LevelGrid& level);

 private:
  HeightLattice build(RightTriangleMesh& start, const Side& side);
  bool may_slide(std::int32_t vertex, const Side& side) const;
  std::int32_t find_notch(std::int32_t vertex, const Side& side, StarFit& fit);
  std::vector<RibbonFlip> cut_notches(const Side& side, StarFit& fit);

  HalfEdgeMesh mesh_;
  EdgeCollapse collapse_;
  Ring ring_;
};

}  // namespace tintree::simplify
