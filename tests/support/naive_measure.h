#pragma once

#include "cache/tile_bounds.h"
#include "codec/grid_frame.h"
#include "codec/tile_mesh.h"
#include "tests/support/test_raster.h"

namespace tintree::test {

/// A tile's figures, found the slow and obvious way: the yardstick for whatever measures fast.
/// Every candidate for the maximum is visited one by one, triangle by triangle, and evaluated from the
/// definitions. For rasters of a few thousand samples.
struct NaiveFigures {
  double z_min_m = 0;
  double z_max_m = 0;
  double error_m = 0;
  double rms_m = 0;           ///< Over the samples of the tile that the mesh covers, each once.
  double border_error_m = 0;  ///< Along the sides of the tile's full square.
};

NaiveFigures naive_figures(const HeightGrid& grid, const codec::TreeLayout& layout, const codec::TileId& id,
                           const codec::TileMesh& mesh);

/// Height of a triangle's plane at a point of the DEM's plane (column, row).
double plane_height(const std::array<std::array<double, 3>, 3>& corners, double column, double row);

}  // namespace tintree::test
