#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "codec/error.h"

namespace tintree::cache {

/// What a DEM says of itself, in the terms the rest of the house uses.
struct RasterInfo {
  std::string path;
  std::int64_t columns = 0;  ///< Samples eastward, 2 or more.
  std::int64_t rows = 0;     ///< Samples southward, 2 or more.
  double dx_m = 1;           ///< Sample spacing in metres (docs/accuracy.md: the local metric frame).
  double dy_m = 1;
  bool geographic = false;               ///< The CRS counts in degrees.
  std::string crs_wkt;                   ///< Empty when the raster states none.
  std::array<double, 6> geotransform{};  ///< GDAL's; pixel corners.
  double height_unit_m = 1;              ///< Metres per unit of the stored heights.
  std::uint64_t file_bytes = 0;
  std::int64_t modified_s = 0;        ///< Seconds since 1970.
  std::vector<std::string> warnings;  ///< What had to be assumed.
};

/// A DEM behind GDAL, read through windows only. Safe to use from several threads; reads take turns.
/// Memory: GDAL's block cache, which set_raster_cache_bytes() limits.
class RasterSource {
 public:
  /// Fails with kIo when the file cannot be opened and with kBadData when it is no north-up raster of
  /// at least 2 x 2 samples with a real-number band.
  static Expected<RasterSource> open(const std::string& path);

  RasterSource(RasterSource&&) noexcept;
  RasterSource& operator=(RasterSource&&) noexcept;
  ~RasterSource();

  const RasterInfo& info() const;

  /// Fills `heights_m` (row-major, north row first, width * height values) with the window whose
  /// north-west sample is (column, row). Samples outside the raster, nodata and infinities are NaN.
  Expected<void> read(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height,
                      double* heights_m) const;

 private:
  struct Impl;
  explicit RasterSource(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Limits what GDAL keeps of decoded blocks, for the whole process.
void set_raster_cache_bytes(std::uint64_t bytes);

}  // namespace tintree::cache
