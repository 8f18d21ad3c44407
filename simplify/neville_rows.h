#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace tintree::simplify {

/// Fills a row of heights in metres from sample (column, row) eastward; NaN where there is none.
using SampleRows = std::function<void(std::int64_t column, std::int64_t row, std::vector<double>& heights_m)>;

/// Rows of one layer of the pyramid over a DEM (Yusov & Turlapov 2008, section 3.2.1), from north to south. Layer 0 is
/// the DEM. A sample of layer k + 1 lies in the middle of four of layer k and has the value of the Neville filter of
/// order 4 there (Kovacevic & Sweldens 2000, table of filters for the quincunx lattice): 10/32 of each of the four
/// nearest, -1/32 of each of the eight around them, which gives every cubic polynomial exactly. Where one of the twelve
/// is missing, the mean of those of the nearest four that are there (order 2); NaN where none is.
/// Memory: four rows of each layer below. Cost: about 4 ns for every sample of the DEM underneath. Not thread-safe.
class NevilleRows {
 public:
  /// Rows of `width` samples from (column, row) of the layer on.
  NevilleRows(const SampleRows& samples, int layer, std::int64_t column, std::int64_t row, int width);

  /// The next row; valid until the next call.
  const std::vector<double>& next();

 private:
  SampleRows samples_;  // layer 0 alone
  std::int64_t column_;
  std::int64_t row_;
  std::unique_ptr<NevilleRows> finer_;
  std::array<std::vector<double>, 4> finer_rows_;  // two of each turn are the last turn's
  bool begun_ = false;
  std::vector<double> out_;
};

}  // namespace tintree::simplify
