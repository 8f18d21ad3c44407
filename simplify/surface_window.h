#pragma once

#include <cstdint>

#include "simplify/extent.h"
#include "simplify/reference_surface.h"

namespace tintree::simplify {

/// Samples of one block, from one of them on: how many columns and rows the block holds eastward and southward.
/// Rows are cache::kBlockStride apart; heights are relative to `base_m`.
struct SampleRun {
  const float* heights;
  std::int64_t columns;
  std::int64_t rows;
  double base_m;
  bool all_valid;  ///< Whether no sample of the block is missing.
};

/// The reference surface in coordinates that count samples from (column0, row0), eastward and southward. Not
/// thread-safe, as the view that it looks through.
class SurfaceWindow {
 public:
  SurfaceWindow(SurfaceView& view, std::int64_t column0, std::int64_t row0)
      : view_(&view), column0_(column0), row0_(row0) {}

  std::int64_t column0() const { return column0_; }
  std::int64_t row0() const { return row0_; }
  bool interrupted() const { return view_->interrupted(); }  ///< SurfaceView::interrupted().

  /// Height of the sample at whole coordinates, NaN when it is missing.
  double sample(std::int64_t x, std::int64_t y) const { return view_->sample(column0_ + x, row0_ + y); }
  /// Height of the surface at a point of its domain, NaN outside.
  double height_at(double x, double y) const;
  /// The samples from (x, y) on; valid until another block is asked for.
  SampleRun run_at(std::int64_t x, std::int64_t y) const;
  /// The residual pyramid's square of size index `size` that holds cell (x, y); null outside the DEM.
  const PlanePatch* patch_at(int size, std::int64_t x, std::int64_t y) const;
  /// The residual pyramid of the block that holds cell (x, y), which has to lie in the DEM.
  const BlockPatches& patches_at(std::int64_t x, std::int64_t y) const {
    return view_->surface().patches((column0_ + x) >> 8, (row0_ + y) >> 8);
  }
  /// The DEM.
  Extent extent() const;

 private:
  SurfaceView* view_;
  std::int64_t column0_;
  std::int64_t row0_;
};

}  // namespace tintree::simplify
