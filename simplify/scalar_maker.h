#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "codec/quantizer.h"
#include "codec/scalar_grid.h"
#include "simplify/level_grid.h"
#include "simplify/surface_distance.h"
#include "simplify/tile_maker.h"

namespace tintree::simplify {

/// Method `scalar` (Fowler et al.): a tile is a regular grid over every 2^n-th sample whose heights are quantised, with
/// a strip along its sides whose outer vertices are border_places(). The grid is the coarsest that keeps the bound with
/// heights on the level's lattice, and the quantiser the coarsest that keeps it on that grid. A tile in which a
/// sample is missing is a grid over every sample. Memory: about 60 bytes a vertex of the grid.
class ScalarMaker final : public TileMaker {
 public:
  ScalarMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, codec::QuantizerKind quantizer,
              const StopFlag* stop = nullptr);

  /// Fails with kBadData, too, when the grid would have more than codec::kMaxGridVertices.
  Expected<codec::TileMesh> make(const codec::TileId& id) override;

 private:
  void begin(const codec::TileId& id);
  bool has_hole();
  Expected<void> choose_stride(const codec::TileId& id);
  Expected<void> take_samples(const codec::TileId& id, std::int64_t stride);
  void quantize(std::int64_t step);
  void choose_uniform();
  void choose_lloyd_max();
  bool quantize_lloyd_max(const std::vector<codec::HeightWeight>& histogram, std::int64_t lowest, std::size_t levels);
  bool fits();
  bool vertices_fit() const;
  bool cells_fit();
  bool strip_fits();
  Point point(std::size_t vertex) const;
  codec::TileMesh take_mesh() const;

  SurfaceView view_;
  codec::TreeLayout layout_;
  codec::QuantizerKind quantizer_;

  // The tile in the making.
  LevelGrid level_;
  std::int64_t column0_ = 0;
  std::int64_t row0_ = 0;
  double bound_m_ = 0;  ///< Guard taken off.
  codec::ScalarGrid grid_;
  std::vector<codec::GridVertex> places_;
  std::vector<double> samples_m_;  ///< At the grid's vertices; NaN where missing.
  std::vector<std::int64_t> z_;    ///< Their heights, in steps from height 0.
  std::optional<SurfaceDistance> distance_;
};

}  // namespace tintree::simplify
