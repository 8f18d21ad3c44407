#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "codec/error.h"
#include "codec/grid_frame.h"

namespace tintree::cache {

/// GDAL's six numbers: x = t[0] + column * t[1] + row * t[2], y = t[3] + column * t[4] + row * t[5] for pixel
/// corners, in the units of the CRS.
using GeoTransform = std::array<double, 6>;

/// How a raster's grid lies in metres (docs/accuracy.md: the local metric frame).
struct RasterFrame {
  double dx_m = 1;  ///< Sample spacing from column to column.
  double dy_m = 1;  ///< Sample spacing from row to row.
  codec::GridAxes axes;
  bool geographic = false;  ///< The CRS counts in degrees.
};

/// The frame of a grid whose rows run clockwise of its columns. An empty WKT takes the units as metres.
/// kBadData when the transform gives no area.
Expected<RasterFrame> raster_frame(const std::string& crs_wkt, const GeoTransform& transform, std::int64_t columns,
                                   std::int64_t rows);

/// Whether two definitions name one CRS.
bool same_crs(const std::string& wkt_a, const std::string& wkt_b);

/// Metres per unit for the unit names that drivers write, or 0 for one we do not know.
double unit_in_metres(std::string name);

}  // namespace tintree::cache
