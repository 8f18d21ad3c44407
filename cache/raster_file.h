#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cache/raster_frame.h"
#include "codec/error.h"

namespace tintree::cache {

/// Which file a tree was made from.
struct InputFile {
  std::string path;
  std::uint64_t bytes = 0;
  std::int64_t modified_s = 0;  ///< Seconds since 1970.

  friend bool operator==(const InputFile&, const InputFile&) = default;
};

/// The file as it is now; size and time are 0 for what GDAL finds under a name that is none of a file.
InputFile describe_input(const std::string& path);
/// Makes GDAL's drivers known, once, and its messages quiet.
void register_drivers();

/// What reading a small window costs beyond its samples.
enum class WindowCost : std::uint8_t {
  kNone,    ///< Uncompressed tiles: nothing.
  kDecode,  ///< Compressed tiles: decoding those it touches.
  kScan,    ///< Rows, large blocks or unknown: much of the raster.
};

/// What one DEM file says of itself. Its grid is numbered so that columns run eastward and rows run clockwise
/// of them, southward unless the grid is rotated: a file that lies the other way is mirrored while reading.
struct RasterFileInfo {
  InputFile input;
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  bool georeferenced = false;
  GeoTransform transform{0, 1, 0, 0, 0, -1};  ///< Of the grid as numbered here.
  std::string crs_wkt;                        ///< Empty when the file states none.
  double height_unit_m = 1;                   ///< Metres per unit of the stored heights.
  bool float_exact = false;                   ///< Every height in metres is exactly a 32-bit float.
  WindowCost window_cost = WindowCost::kScan;
  bool stored_by_rows = false;        ///< Its blocks are as wide as the raster.
  std::uint64_t decoded_bytes = 0;    ///< Of all samples in the file's own type.
  std::vector<std::string> warnings;  ///< What had to be assumed.
};

/// The first band of one raster behind GDAL. Not thread-safe.
class RasterFile {
 public:
  /// kIo when the file cannot be opened, kBadData when it holds no real-number band.
  static Expected<RasterFile> open(const std::string& path);

  RasterFile(RasterFile&&) noexcept;
  RasterFile& operator=(RasterFile&&) noexcept;
  ~RasterFile();

  const RasterFileInfo& info() const;

  /// Reads a window inside the raster, row-major, rows `stride` doubles apart: metres, NaN for declared
  /// nodata, masked-out samples, NaN and infinities. Opens the file again after close().
  Expected<void> read(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height, double* heights_m,
                      std::int64_t stride);

  /// Fails with kIo when the file's size or time has changed since it was opened first. A file that was removed
  /// meanwhile can be read to the end.
  Expected<void> check_unchanged() const;

  /// Gives the file and GDAL's blocks of it back.
  void close();
  bool is_open() const;

 private:
  struct Impl;
  explicit RasterFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Limits what GDAL keeps of decoded blocks, for the whole process.
void set_raster_cache_bytes(std::uint64_t bytes);

}  // namespace tintree::cache
