#pragma once

#include "simplify/border_ribbon.h"
#include "simplify/edge_collapse.h"
#include "simplify/half_edge_mesh.h"
#include "simplify/right_triangle_mesh.h"
#include "simplify/tile_maker.h"

namespace tintree::simplify {

/// Method `tin` (Wahl et al. 2004): a tile starts from right triangles at its bound over its own window of the
/// DEM, takes over the settled vertices of its four sides, and is simplified by edge collapse against the DEM
/// itself.
class TinMaker final : public TileMaker {
 public:
  TinMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, const StopFlag* stop = nullptr);

  Expected<codec::TileMesh> make(const codec::TileId& id) override;

 private:
  void settle_side(RightTriangleMesh& start, const Side& side, const LevelGrid& level, const codec::TileId& id);
  void classify(std::int64_t cells);
  Expected<codec::TileMesh> take_mesh(const codec::TileId& id) const;

  SurfaceView view_;
  codec::TreeLayout layout_;
  HalfEdgeMesh mesh_;
  EdgeCollapse collapse_;
  BorderRibbon ribbon_;
};

}  // namespace tintree::simplify
