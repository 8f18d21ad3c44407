#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cache/raster_file.h"
#include "cache/raster_frame.h"
#include "cache/raster_source.h"
#include "codec/error.h"
#include "codec/grid_frame.h"

namespace tintree::cache {

/// Colours of a rectangle of nodes, row-major, 4 bytes a node: sRGB and alpha.
struct ColorWindow {
  std::int64_t column0 = 0;
  std::int64_t row0 = 0;
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
};

/// Orthophotos behind GDAL, in any format and CRS, as colours at the nodes of a grid over a DEM: node (i, j) of a grid
/// of step s lies at the DEM's column i * s, row j * s. Reprojected by GDAL's warper, with its cubic filter, window by
/// window; where photos overlap the later one counts. Nothing of a photo is held in memory beyond GDAL's block cache
/// (set_raster_cache_bytes()). Safe to use from several threads; reads take turns.
class OrthoSource {
 public:
  /// kIo when a file cannot be opened; kBadData when one holds no colours of 8 bits, has no georeference, or does not
  /// meet the DEM anywhere. `dem` must hold the DEM's CRS, georeference and size.
  static Expected<OrthoSource> open(const std::vector<std::string>& paths, const RasterInfo& dem);

  OrthoSource(OrthoSource&&) noexcept;
  OrthoSource& operator=(OrthoSource&&) noexcept;
  ~OrthoSource();

  const std::vector<InputFile>& inputs() const;
  /// What had to be assumed.
  const std::vector<std::string>& warnings() const;
  /// Side of the finest photo's pixels in samples of the DEM, in the middle of the photo.
  double pixel_samples() const;
  /// The same of those photos only that may reach into a rectangle of the DEM's grid; infinite where none does.
  double pixel_samples_in(const codec::CellRect& cells) const;
  /// Fails with kIo when a file's size or time has changed since it was opened.
  Expected<void> check_unchanged() const;

  /// Copies photos that are stored by rows, and do not fit into `cache_bytes`, into temporary files in `folder`, which
  /// have no name any more when this returns. Called with (step, done, total); returns false to stop (kStopped).
  Expected<void> stage(const std::string& folder, std::uint64_t cache_bytes,
                       const std::function<bool(const std::string&, std::uint64_t, std::uint64_t)>& progress);

  /// The nodes from (column0, row0) on, which may lie outside the DEM. `step` in samples of the DEM. Alpha is 0 where
  /// no photo covers a node.
  Expected<ColorWindow> read(double step, std::int64_t column0, std::int64_t row0, int width, int height) const;

 private:
  struct Impl;
  explicit OrthoSource(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tintree::cache
