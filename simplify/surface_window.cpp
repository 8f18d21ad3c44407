#include "simplify/surface_window.h"

#include <algorithm>
#include <cmath>

namespace tintree::simplify {

SampleRun SurfaceWindow::run_at(std::int64_t x, std::int64_t y) const {
  const cache::HeightBlocks& blocks = view_->surface().blocks();
  const std::int64_t column = column0_ + x;
  const std::int64_t row = row0_ + y;
  // The last column and row belong to the block before them.
  const std::int64_t cell_x = std::min(column, blocks.columns() - 2);
  const std::int64_t cell_y = std::min(row, blocks.rows() - 2);
  const cache::HeightBlock& block = view_->block_of(cell_x, cell_y);
  const std::int64_t i = column - (cell_x & ~std::int64_t{255});
  const std::int64_t j = row - (cell_y & ~std::int64_t{255});
  return {block.row(static_cast<int>(j)) + i, cache::kBlockSamples - i, cache::kBlockSamples - j, block.base_m,
          block.all_valid};
}

const PlanePatch* SurfaceWindow::patch_at(int size, std::int64_t x, std::int64_t y) const {
  const std::int64_t column = column0_ + x;
  const std::int64_t row = row0_ + y;
  const cache::HeightBlocks& blocks = view_->surface().blocks();
  if (column < 0 || row < 0 || column >= blocks.columns() - 1 || row >= blocks.rows() - 1) return nullptr;
  return &view_->surface()
              .patches(column >> 8, row >> 8)
              .at(size, static_cast<int>(column & 255), static_cast<int>(row & 255));
}

Extent SurfaceWindow::extent() const {
  const cache::HeightBlocks& blocks = view_->surface().blocks();
  return {static_cast<double>(-column0_), static_cast<double>(-row0_),
          static_cast<double>(blocks.columns() - 1 - column0_), static_cast<double>(blocks.rows() - 1 - row0_)};
}

double SurfaceWindow::height_at(double x, double y) const {
  const auto i = static_cast<std::int64_t>(std::floor(x));
  const auto j = static_cast<std::int64_t>(std::floor(y));
  const double fx = x - static_cast<double>(i);
  const double fy = y - static_cast<double>(j);
  // Points on a grid line use the samples of that line alone: beyond it the surface may end.
  const double corner = sample(i, j);
  if (fx == 0 && fy == 0) return corner;
  if (fy == 0) return corner + fx * (sample(i + 1, j) - corner);
  if (fx == 0) return corner + fy * (sample(i, j + 1) - corner);
  const double opposite = sample(i + 1, j + 1);
  if (fx == fy) return corner + fx * (opposite - corner);
  if (fx > fy) {
    const double east = sample(i + 1, j);
    return corner + fx * (east - corner) + fy * (opposite - east);
  }
  const double south = sample(i, j + 1);
  return corner + fy * (south - corner) + fx * (opposite - south);
}

}  // namespace tintree::simplify
