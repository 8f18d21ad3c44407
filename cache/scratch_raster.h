#pragma once

#include <cstdint>
#include <string>

#include "cache/scratch_file.h"
#include "codec/error.h"

namespace tintree::cache {

/// What a sample takes in the file. kFloat is exact for heights that are 32-bit floats already.
enum class ScratchSample : std::uint8_t { kFloat = 4, kDouble = 8 };

/// A raster in a temporary file that has no name, so that it is gone with this object, however the program
/// ends. Uncompressed blocks of 256 x 256 samples: any window is read at the price of its samples. Takes no
/// memory of its own. Reads may come from any thread once writing is over.
class ScratchRaster {
 public:
  /// Makes the file in `folder`. kIo when it cannot, or when the disk has no room for all samples.
  static Expected<ScratchRaster> create(const std::string& folder, std::int64_t columns, std::int64_t rows,
                                        ScratchSample sample);

  /// Stores a window that lies inside the raster, row-major, `stride` doubles a row. Quickest for whole rows
  /// of blocks. Not thread-safe.
  Expected<void> write(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height,
                       const double* values, std::int64_t stride);
  /// Reads a window that lies inside the raster into rows `stride` doubles apart.
  Expected<void> read(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height, double* values,
                      std::int64_t stride) const;

 private:
  ScratchRaster(ScratchFile file, std::int64_t columns, ScratchSample sample);
  std::int64_t position(std::int64_t block_x, std::int64_t block_y, std::int64_t row) const;

  ScratchFile file_;
  std::int64_t columns_ = 0;
  ScratchSample sample_ = ScratchSample::kDouble;
};

}  // namespace tintree::cache
