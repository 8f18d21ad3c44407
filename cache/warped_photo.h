#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "cache/photo.h"
#include "cache/raster_source.h"
#include "codec/error.h"

namespace tintree::cache {

/// A photo brought to the nodes of a grid over a DEM by GDAL's warper, with its cubic filter, window by window. Not
/// thread-safe.
class WarpedPhoto {
 public:
  /// `step`: samples of the DEM between nodes. The photo must outlive it. kBadData when GDAL cannot bring it there.
  static Expected<WarpedPhoto> make(const Photo& photo, const RasterInfo& dem, double step);

  /// The colours of width x height nodes from (column0, row0) on, row-major, 4 bytes a node: sRGB and alpha, 0 where
  /// the photo covers none.
  Expected<void> read(std::int64_t column0, std::int64_t row0, int width, int height,
                      std::span<std::uint8_t> rgba) const;

 private:
  WarpedPhoto(DatasetPtr nodes, std::string path) : nodes_(std::move(nodes)), path_(std::move(path)) {}

  DatasetPtr nodes_;
  std::string path_;
};

}  // namespace tintree::cache
