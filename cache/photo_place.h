#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>

#include "cache/photo.h"
#include "cache/raster_frame.h"
#include "cache/raster_source.h"
#include "codec/error.h"
#include "codec/grid_frame.h"

namespace tintree::cache {

/// Nodes of a grid over a DEM that lie before its first one, northward and westward, and count as columns and rows of a
/// photo that is brought to that grid: windows may reach so far beyond the DEM.
constexpr std::int64_t kNodesBefore = 1 << 12;

/// The georeference of a grid of nodes `step` samples of the DEM apart: its pixels' centres are the nodes, which begin
/// kNodesBefore before the DEM.
GeoTransform node_transform(const GeoTransform& dem, double step);

struct TransformerCloser {
  void operator()(void* transformer) const;
};
/// GDAL's way from a photo's pixels to those of a grid of nodes.
using Transformer = std::unique_ptr<void, TransformerCloser>;
/// kBadData when the photo's CRS cannot be brought to the DEM's.
Expected<Transformer> make_transformer(const Photo& photo, const RasterInfo& dem, const GeoTransform& nodes);

/// How a photo lies over a DEM.
struct PhotoPlace {
  bool meets = false;        ///< The DEM, somewhere.
  double pixel_samples = 0;  ///< Side of its pixels in samples of the DEM, in its middle; 0 where that is not known.
  /// The columns and rows of the DEM's grid that it lies between.
  std::array<double, 2> low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::array<double, 2> high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

  /// Whether it may reach into a rectangle of the DEM's grid.
  bool reaches(const codec::CellRect& cells) const;
  void add(double column, double row);
  /// Takes it to lie anywhere.
  void add_everything();
};

/// Probes the photo and the DEM at 17 x 17 places each.
Expected<PhotoPlace> place_photo(const Photo& photo, const RasterInfo& dem);

}  // namespace tintree::cache
