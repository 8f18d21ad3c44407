#pragma once

#include "simplify/border_ribbon.h"
#include "simplify/edge_collapse.h"
#include "simplify/half_edge_mesh.h"
#include "simplify/right_triangle_mesh.h"
#include "simplify/tile_maker.h"

namespace tintree::simplify {

/// Method `tin` (Wahl et al. 2004): a tile starts from right triangles at its bound over its own window of the
/// DEM, takes over the settled vertices of its four sides, and is simplified by edge collapse against the DEM
/// itself. With the best effort its payload is CodedTinMesh's, with the fast one DracoMesh's.
class TinMaker final : public TileMaker {
 public:
  TinMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, Effort effort = Effort::kFast,
           const StopFlag* stop = nullptr);

  Expected<codec::TileMesh> make(const codec::TileId& id) override;
  Expected<std::vector<std::byte>> encode(const codec::MeshCodec& codec, const codec::TileId& id,
                                          const codec::TileMesh& mesh) override;

 private:
  void settle_side(RightTriangleMesh& start, const Side& side, const LevelGrid& level, const codec::TileId& id);
  void repeat(const RibbonFlip& flip, std::int32_t near, const Side& side);
  void repeat(const RibbonStep& step, std::int32_t gone, const Side& side);
  void refine_lattice(int sub_bits);
  void classify(std::int64_t span);
  Expected<codec::TileMesh> take_mesh(const codec::TileId& id, int sub_bits) const;

  SurfaceView view_;
  codec::TreeLayout layout_;
  Effort effort_;
  HalfEdgeMesh mesh_;
  HeightLattice heights_;  // what its z counts
  EdgeCollapse collapse_;
  BorderRibbon ribbon_;
};

}  // namespace tintree::simplify
