#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "apps/audit/vertical_distance.h"
#include "codec/grid_frame.h"

namespace tintree::audit {

/// The largest error under each pixel of a picture over a rectangle of the DEM. What is put in may come from
/// several threads in any order. Memory: 4 bytes a pixel.
class ErrorMap {
 public:
  /// At most `longest_px` pixels along the longer side, none smaller than a sample.
  ErrorMap(const codec::CellRect& cells, int longest_px);

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  /// Metres; NaN where no sample is covered.
  float at(int x_px, int y_px) const { return errors_m_[static_cast<std::size_t>(y_px * width_px_ + x_px)]; }

  /// Adds one window of a tile whose north-west sample is (column0, row0).
  void add(std::int64_t column0, std::int64_t row0, const SampleErrors& errors, const Peak& peak);

 private:
  int x_of(std::int64_t column) const;
  int y_of(std::int64_t row) const;

  codec::CellRect cells_;
  int width_px_;
  int height_px_;
  std::mutex turn_;
  std::vector<float> errors_m_;
};

}  // namespace tintree::audit
