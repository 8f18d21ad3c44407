#pragma once

#include <cstdint>
#include <vector>

#include "codec/quantizer.h"
#include "codec/scalar_grid.h"
#include "simplify/scalar_blocks.h"
#include "simplify/tile_maker.h"

namespace tintree::simplify {

/// Method `scalar` (Fowler et al.): a tile is a quadtree of regular grids, each over every 2^n-th sample, whose heights
/// are quantised, stitched to each other and to vertices at border_places() of the sides. Each grid is the
/// coarsest that keeps the bound with the heights so quantised. Samples are missing in grids over every sample alone.
/// Memory: about 120 bytes a vertex.
class ScalarMaker final : public TileMaker {
 public:
  ScalarMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, codec::QuantizerKind quantizer,
              const StopFlag* stop = nullptr);

  /// Fails with kBadData, too, when the grids would have more than codec::kMaxGridVertices.
  Expected<codec::TileMesh> make(const codec::TileId& id) override;

 private:
  ScalarSpec spec(const codec::TileId& id);
  codec::ScalarShape choose_quantizer(ScalarSpec& spec, double reach_m, double relief_m);
  void set_heights(codec::ScalarTile& tile) const;

  SurfaceView view_;
  codec::TreeLayout layout_;
  codec::QuantizerKind quantizer_;

  // The tile in the making.
  std::vector<double> samples_m_;  ///< At the grid's vertices; NaN where missing.
  std::vector<std::int64_t> z_;    ///< Their heights, in steps from height 0.
};

}  // namespace tintree::simplify
