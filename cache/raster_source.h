#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cache/raster_file.h"
#include "cache/raster_frame.h"
#include "codec/error.h"
#include "codec/grid_frame.h"

namespace tintree::cache {

/// What becomes of samples without a height.
enum class NodataPolicy : std::uint8_t {
  kHole,  ///< They are missing from the surface.
  kFill,  ///< Those within kFillDistance samples of a height get one (docs/guide.md, Inputs).
};

/// How far GDALFillNodata looks for heights: what gdal_fillnodata takes unless told otherwise.
inline constexpr int kFillDistance = 100;

/// What a DEM says of itself, in the terms the rest of the house uses.
struct RasterInfo {
  std::string path;               ///< For messages: the file, or the first and how many more.
  std::vector<InputFile> inputs;  ///< In the order given.
  std::int64_t columns = 0;       ///< Samples along a row, 2 or more.
  std::int64_t rows = 0;          ///< 2 or more.
  double dx_m = 1;                ///< Sample spacing in metres (docs/accuracy.md: the local metric frame).
  double dy_m = 1;
  codec::GridAxes axes;
  bool geographic = false;            ///< The CRS counts in degrees.
  std::string crs_wkt;                ///< Empty when the raster states none.
  GeoTransform geotransform{};        ///< Of the grid as numbered here; pixel corners.
  double height_unit_m = 1;           ///< Metres per unit of the stored heights, in the first file.
  std::vector<std::string> warnings;  ///< What had to be assumed.
};

/// What to make ready before a raster is read in small windows.
struct StageOptions {
  NodataPolicy nodata = NodataPolicy::kHole;
  std::string folder = ".";  ///< Of temporary files: 4 bytes a sample, 8 where a 32-bit float cannot hold the heights.
  /// What GDAL may keep of decoded blocks after this; a raster stored by rows or in large blocks that exceeds
  /// it is copied.
  std::uint64_t raster_cache_bytes = ~std::uint64_t{0};
  /// What the caller keeps of heights, 4 bytes a sample; a raster in compressed tiles that exceeds it is copied.
  std::uint64_t block_cache_bytes = ~std::uint64_t{0};
  /// Called with (step, done, total); returns false to stop (kStopped).
  std::function<bool(const std::string&, std::uint64_t, std::uint64_t)> progress = {};
};

/// A DEM of one or several files behind GDAL, read through windows only. Where files overlap, the later one
/// counts, but a sample that it lacks is taken from those before it; what no file covers is missing. Safe to
/// use from several threads; reads take turns until the raster is copied. Memory: GDAL's block cache, which
/// set_raster_cache_bytes() limits.
class RasterSource {
 public:
  /// kIo when a file cannot be opened; kBadData when one is no raster, when they do not lie on one grid (the
  /// message says how to bring them there), or when all together are not at least 2 x 2 samples.
  static Expected<RasterSource> open(const std::vector<std::string>& paths);
  static Expected<RasterSource> open(const std::string& path) { return open(std::vector{path}); }

  RasterSource(RasterSource&&) noexcept;
  RasterSource& operator=(RasterSource&&) noexcept;
  ~RasterSource();

  const RasterInfo& info() const;
  /// Fails with kIo when a file's size or time has changed since it was opened. A file that was removed meanwhile can
  /// be read to the end, and once they are copied they do not matter any more.
  Expected<void> check_unchanged() const;

  /// Fills holes if asked to, and copies the heights into a temporary file if windows would otherwise decode
  /// much of the raster again and again. The copy is exact. Not thread-safe.
  Expected<void> stage(const StageOptions& options);
  /// Whether stage() has made a copy, so that GDAL needs no memory any more.
  bool is_copied() const;

  /// Fills `heights_m` (row-major, width * height values) with the window whose first sample is (column,
  /// row). Samples outside the raster, nodata and infinities are NaN.
  Expected<void> read(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height,
                      double* heights_m) const;

 private:
  struct Impl;
  explicit RasterSource(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tintree::cache
