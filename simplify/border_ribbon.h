#pragma once

#include <cstdint>
#include <vector>

#include "simplify/edge_collapse.h"
#include "simplify/half_edge_mesh.h"
#include "simplify/level_grid.h"
#include "simplify/reference_surface.h"
#include "simplify/right_triangle_mesh.h"

namespace tintree::simplify {

/// A vertex of a side that goes: sample `index` along the side merges into the next vertex towards the
/// side's start (`towards` -1) or end (+1), which then has height address `z`.
struct RibbonStep {
  std::int32_t index;
  std::int32_t towards;
  std::int32_t z;
};

/// Settles the vertices on the sides of tiles, as a pure function of the samples near each side: both
/// tiles at it compute the same, with no communication, and neither gets stuck (docs/accuracy.md, Borders).
/// The triangles of the level's start mesh that touch the side, cut at 45 degrees towards its two ends, form a
/// band; its line is simplified by the ordinary collapse under the ordinary bound, and half of that along the
/// line; the rim stays. A tile begins with its half of that band. Not thread-safe; reuses its memory.
class BorderRibbon {
 public:
  /// Steps in the order in which they were made. The guard taken off the level's bound depends on the side alone,
  /// never on the tile that asks.
  std::vector<RibbonStep> settle(SurfaceView& view, RightTriangleMesh& start, const Side& side, const LevelGrid& level);

 private:
  void build(RightTriangleMesh& start, const Side& side);
  bool may_slide(std::int32_t vertex, const Side& side) const;

  HalfEdgeMesh mesh_;
  EdgeCollapse collapse_;
};

}  // namespace tintree::simplify
