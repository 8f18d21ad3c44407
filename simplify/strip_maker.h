#pragma once

#include "simplify/tile_maker.h"

namespace tintree::simplify {

/// Method `strip` (Dick et al. 2009): a tile is the restricted quadtree mesh at its bound, at heights rounded to half
/// the bound: off by a quarter of it at most, as in the paper. With the
/// best effort its payload is CodedStripMesh's, with the fast one StripMesh's.
class StripMaker final : public TileMaker {
 public:
  StripMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, Effort effort = Effort::kFast,
             const StopFlag* stop = nullptr);

  Expected<codec::TileMesh> make(const codec::TileId& id) override;
  Expected<std::vector<std::byte>> encode(const codec::MeshCodec& codec, const codec::TileId& id,
                                          const codec::TileMesh& mesh) override;

 private:
  SurfaceView view_;
  codec::TreeLayout layout_;
  Effort effort_;
};

}  // namespace tintree::simplify
