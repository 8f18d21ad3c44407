#pragma once

#include <vector>

#include "apps/audit/color_scale.h"
#include "apps/audit/tile_surface.h"
#include "cache/raster_source.h"
#include "codec/grid_frame.h"

namespace tintree::audit {

/// Heights at the pixels of a small picture over a rectangle of the DEM: every pixel is one sample. Row-major,
/// metres, NaN where there is no surface.
struct HeightPicture {
  codec::CellRect cells;
  int width_px = 0;
  int height_px = 0;
  std::vector<double> heights_m;

  HeightPicture(const codec::CellRect& rectangle, int longest_px);
  /// DEM column and row of a pixel.
  std::int64_t column(int x_px) const;
  std::int64_t row(int y_px) const;
  double at(int x_px, int y_px) const { return heights_m[static_cast<std::size_t>(y_px * width_px + x_px)]; }
};

/// The DEM itself, one row of samples a row of pixels.
Expected<HeightPicture> picture_of_dem(const cache::RasterSource& source, const codec::CellRect& cells, int longest_px);

/// A tile's mesh.
HeightPicture picture_of_mesh(const TileSurface& surface, int longest_px);

/// Vertical exaggeration that gives the picture's slopes some contrast, 1 to 30.
double relief_gain(const HeightPicture& picture, const codec::TreeLayout& layout);

/// Lit from the north-west, 45 degrees high, in shades of grey.
app::RgbImage shade(const HeightPicture& picture, const codec::TreeLayout& layout, double gain);

}  // namespace tintree::audit
