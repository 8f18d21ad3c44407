#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "cache/raster_source.h"

class GDALDataset;

namespace tintree::test {

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

enum class SampleType { kInt16, kFloat32, kFloat64 };

/// A small GeoTIFF to make.
struct RasterSpec {
  int columns = 17;
  int rows = 17;
  double dx = 1;  ///< Pixel size in the units of the CRS.
  double dy = 1;
  double west = 1000;  ///< CRS coordinates of the upper-left pixel's outer corner.
  double north = 2000;
  double turn_rad = 0;  ///< The grid is turned by this round that corner, counter-clockwise.
  int epsg = 32610;     ///< 0: no CRS, and no georeference either.
  SampleType type = SampleType::kFloat64;
  std::optional<double> nodata = -9999;  ///< Written for missing samples; without it NaN is.
  int tile = 0;                          ///< Side of the blocks; 0: rows.
  bool deflate = false;
};

/// Gives a dataset the place and CRS of `spec`; throws std::runtime_error when GDAL refuses.
void set_georeference(GDALDataset& dataset, const RasterSpec& spec);

/// Height of the sample at (column, row); kMissing for none.
using HeightFunction = std::function<double(int column, int row)>;

/// Writes a GeoTIFF; throws std::runtime_error when GDAL cannot.
void write_raster(const std::string& path, const RasterSpec& spec, const HeightFunction& height);

/// All samples of a small DEM as RasterSource gives them, row-major, north row first.
struct HeightGrid {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  std::vector<double> heights_m;

  /// NaN outside the raster too.
  double at(std::int64_t column, std::int64_t row) const;
  /// The reference surface at a point; NaN where it has none.
  double surface(double column, double row) const;
  /// Whether the reference triangle of cell (column, row) below the diagonal (north-west, south-west,
  /// south-east) exists, or the one above it (north-west, south-east, north-east).
  bool has_lower(std::int64_t column, std::int64_t row) const;
  bool has_upper(std::int64_t column, std::int64_t row) const;
};

HeightGrid read_grid(const cache::RasterSource& source);
HeightGrid read_grid(const std::string& path);

/// Smooth hills with some roughness, deterministic, within about -`relief`..`relief`.
double hills(int column, int row, double relief = 20);

/// A hash of the arguments, uniform in [0, 1).
double noise(int column, int row, unsigned seed = 0);

/// Hills of `relief` metres with noise of `roughness` metres, and each sample missing with chance `holes`.
HeightFunction rough_hills(double relief, double roughness, double holes, unsigned seed = 0);

}  // namespace tintree::test
