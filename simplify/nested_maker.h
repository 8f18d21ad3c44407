#pragma once

#include "codec/nested_points.h"
#include "simplify/restricted_quadtree.h"
#include "simplify/tile_maker.h"

namespace tintree::simplify {

/// Method `nested` (Schneider and Westermann 2006, section 4): a tile is the finest of nine nested restricted
/// quadtree meshes over it, whose tolerances are the level's bound times 1, 2, 4, ..., 256. The vertices of a coarser
/// one are among those of the finer. A coarser mesh is not refined where its vertices would come closer together than
/// its tolerance (the paper's second condition), so on cliffs it can be further off than that; not so the tile's own,
/// nor one of a tile with a hole or at the raster's end, whose outline every level follows.
class NestedMaker final : public TileMaker {
 public:
  NestedMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, const StopFlag* stop = nullptr);

  Expected<codec::TileMesh> make(const codec::TileId& id) override;

 private:
  codec::NestedPoints collect_points(std::int64_t column0, std::int64_t row0, std::int64_t cells, double bound_m,
                                     const HeightLattice& heights);

  SurfaceView view_;
  codec::TreeLayout layout_;
};

}  // namespace tintree::simplify
