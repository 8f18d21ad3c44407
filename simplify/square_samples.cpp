#include "simplify/square_samples.h"

#include <cmath>

namespace tintree::simplify {

bool SquareSamples::read(SurfaceView& view, std::int64_t column, std::int64_t row, const HeightLattice& heights) {
  const cache::HeightBlocks& blocks = view.surface().blocks();
  if (column < 0 || row < 0 || column + kCells >= blocks.columns() || row + kCells >= blocks.rows()) return false;
  const cache::HeightBlock& block = view.block_of(column, row);
  double sum = 0;
  for (std::size_t j = 0; j < kLine; ++j) {
    const float* line = block.row(static_cast<int>(row & 255) + static_cast<int>(j)) + (column & 255);
    for (std::size_t i = 0; i < kLine; ++i) {
      const double h = static_cast<double>(line[i]) + block.base_m;
      samples[j][i] = h;
      sum += h;
    }
  }
  if (std::isnan(sum)) return false;
  for (std::size_t j = 0; j < kLine; ++j) {
    for (std::size_t i = 0; i < kLine; ++i) snapped[j][i] = heights.snapped_m(samples[j][i]);
  }
  return true;
}

}  // namespace tintree::simplify
