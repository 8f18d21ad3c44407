#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "codec/error.h"

class GDALDataset;

namespace tintree::cache {

struct DatasetCloser {
  void operator()(GDALDataset* dataset) const;
};
using DatasetPtr = std::unique_ptr<GDALDataset, DatasetCloser>;

/// One photo behind GDAL: its pixels, and which of its bands are colours of 8 bits and which is alpha. A photo of one
/// band is grey, one with a colour table has that table's colours. Not thread-safe.
class Photo {
 public:
  /// kIo when there is no such file, kBadData when it is no picture or holds no colours of 8 bits.
  static Expected<Photo> open(const std::string& path);

  const std::string& path() const { return path_; }
  GDALDataset& dataset() const { return *dataset_; }
  /// Numbers of the bands of red, green and blue.
  const std::array<int, 3>& bands() const { return bands_; }
  int alpha_band() const { return alpha_band_; }  ///< 0: none.

  bool has_place() const;   ///< Whether it says where it lies,
  bool states_crs() const;  ///< and in which CRS.

  /// Copies a photo that is stored by rows, and does not fit into `cache_bytes`, into a temporary file in `folder` that
  /// is stored by tiles and has no name any more when this returns. Windows of the photo are read from there then.
  Expected<void> stage(const std::string& folder, std::uint64_t cache_bytes);

 private:
  explicit Photo(std::string path) : path_(std::move(path)) {}
  Expected<void> expand_palette();
  Expected<void> describe_bands();

  std::string path_;
  DatasetPtr indices_;  ///< Of a photo with a colour table: what its dataset reads from.
  DatasetPtr dataset_;
  std::array<int, 3> bands_{1, 1, 1};
  int alpha_band_ = 0;
};

}  // namespace tintree::cache
