#pragma once

#include <memory>

#include "codec/patch_cache.h"
#include "codec/wavelet_patch.h"
#include "simplify/right_triangle_mesh.h"
#include "simplify/tile_maker.h"

namespace tintree::simplify {

/// Method `wavelet` (Yusov & Turlapov 2008): a tile's triangles are those of its level's RightTriangleMesh, within the
/// bound of the DEM itself and the same for both tiles at a side; its heights are coded against the tile's patch of
/// the layered pyramid, which is coded against the parent's reconstructed one. So a tile needs the patches of all
/// tiles above: they too are made of the DEM alone, and the last ones kept.
class WaveletMaker final : public TileMaker {
 public:
  /// The patches keep to the criterion with their level's bound.
  WaveletMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, codec::PatchCriterion criterion,
               const StopFlag* stop = nullptr);

  Expected<codec::TileMesh> make(const codec::TileId& id) override;
  Expected<std::vector<std::byte>> encode(const codec::MeshCodec& codec, const codec::TileId& id,
                                          const codec::TileMesh& mesh) override;
  /// Above the parent all ground is level. Reads until the next call.
  Expected<TileReader> stand_in_above(const codec::TileId& id) override;

 private:
  Expected<std::shared_ptr<const codec::EncodedPatch>> patch(const codec::TileId& id);
  codec::Patch target(const codec::TileId& id);

  SurfaceView view_;
  codec::TreeLayout layout_;
  codec::PatchCriterion criterion_;
  codec::PatchCache<codec::EncodedPatch> patches_;
};

}  // namespace tintree::simplify
