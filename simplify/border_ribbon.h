#pragma once

#include <cstdint>
#include <vector>

#include "simplify/edge_collapse.h"
#include "simplify/half_edge_mesh.h"
#include "simplify/height_lattice.h"
#include "simplify/reference_surface.h"

namespace tintree::simplify {

/// One side that two tiles share: `cells` DEM cells from sample (column, row) eastward or southward.
struct Side {
  std::int64_t column = 0;
  std::int64_t row = 0;
  std::int64_t cells = 0;
  bool southward = false;
};

/// A vertex of a side that goes: sample `index` along the side merges into the next vertex towards the
/// side's start (`towards` -1) or end (+1), which then has height address `z`.
struct RibbonStep {
  std::int32_t index;
  std::int32_t towards;
  std::int32_t z;
};

/// Whether the cell with its north-west sample at (column, row) may have its diagonal flipped from the
/// surface's own to the other one, at snapped heights: it has all its samples, and the flip stays within the
/// level's `bound_m`, less the guard.
bool may_flip(SurfaceView& view, std::int64_t column, std::int64_t row, double bound_m, const HeightLattice& heights);

/// Settles the vertices on the sides of tiles, as a pure function of the samples near each side: both
/// tiles at it compute the same, with no communication, and neither gets stuck (docs/accuracy.md, Borders).
/// The band of one cell on either side is triangulated at full resolution, cut at 45 degrees towards the two
/// corners, and its middle line is simplified by the ordinary collapse under the ordinary bound, and half
/// of that along the line; the rim stays. A tile begins with its half of that band. Cost: linear in the
/// side's length. Not thread-safe; reuses its memory.
class BorderRibbon {
 public:
  /// Steps in the order in which they were made. `bound_m` is the level's; the guard taken off it depends on the
  /// side alone, never on the tile that asks.
  std::vector<RibbonStep> settle(SurfaceView& view, const Side& side, double bound_m, const HeightLattice& heights);

 private:
  void build(SurfaceView& view, const Side& side, double bound_m, const HeightLattice& heights);
  void classify(const Side& side);

  HalfEdgeMesh mesh_;
  EdgeCollapse collapse_;
  std::vector<std::int32_t> line_;  // vertex of each sample along the side, or kNone
  std::vector<std::uint8_t> held_;  // samples along the side that have to stay
};

}  // namespace tintree::simplify
