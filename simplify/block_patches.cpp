#include "simplify/block_patches.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "codec/float_rounding.h"

namespace tintree::simplify {
namespace {

using cache::HeightBlock;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Least-squares plane through 17 x 17 samples of the square, then the exact residual range over all.
PlanePatch fit(const HeightBlock& block, int i0, int j0, int cells) {
  const int stride = cells / 16;
  double sum = 0;
  double sum_x = 0;
  double sum_y = 0;
  for (int j = 0; j <= 16; ++j) {
    const float* line = block.row(j0 + j * stride) + i0;
    for (int i = 0; i <= 16; ++i) {
      const double h = line[i * stride];
      sum += h;
      sum_x += (i - 8) * h;
      sum_y += (j - 8) * h;
    }
  }
  // The sum of (i - 8)^2 over 17 x 17 points is 17 * 408.
  PlanePatch patch;
  patch.a = static_cast<float>(sum_x / (17 * 408) / stride);
  patch.b = static_cast<float>(sum_y / (17 * 408) / stride);
  const double centre = cells / 2;
  patch.c = static_cast<float>(sum / 289 - (static_cast<double>(patch.a) + static_cast<double>(patch.b)) * centre +
                               block.base_m);
  if (!std::isfinite(patch.a) || !std::isfinite(patch.b) || !std::isfinite(patch.c)) {
    patch.a = patch.b = 0;
    patch.c = static_cast<float>(block.base_m);
  }

  double low = kInfinity;
  double high = -kInfinity;
  int low_row = 0;
  int high_row = 0;
  const auto residual = [&](int i, int j) {
    const double start = static_cast<double>(patch.c) - block.base_m + static_cast<double>(patch.b) * j;
    return static_cast<double>(block.row(j0 + j)[i0 + i]) - (start + static_cast<double>(patch.a) * i);
  };
  for (int j = 0; j <= cells; ++j) {
    double row_low = kInfinity;
    double row_high = -kInfinity;
    for (int i = 0; i <= cells; ++i) {
      const double r = residual(i, j);
      row_low = r < row_low ? r : row_low;
      row_high = r > row_high ? r : row_high;
    }
    if (row_low < low) low = row_low, low_row = j;
    if (row_high > high) high = row_high, high_row = j;
  }
  patch.low = codec::round_down(low);
  patch.high = codec::round_up(high);
  for (int i = 0; i <= cells; ++i) {
    if (residual(i, low_row) == low) patch.low_x = static_cast<std::uint8_t>(i);
    if (residual(i, high_row) == high) patch.high_x = static_cast<std::uint8_t>(i);
  }
  patch.low_y = static_cast<std::uint8_t>(low_row);
  patch.high_y = static_cast<std::uint8_t>(high_row);
  return patch;
}

bool any_missing(const HeightBlock& block, int i0, int j0, int cells) {
  for (int j = 0; j <= cells; ++j) {
    const float* line = block.row(j0 + j) + i0;
    if (std::any_of(line, line + cells + 1, [](float h) { return std::isnan(h); })) return true;
  }
  return false;
}

PlanePatch make_patch(const HeightBlock& block, int i0, int j0, int cells) {
  PlanePatch patch = fit(block, i0, j0, cells);
  if (!block.all_valid && !patch.empty() && any_missing(block, i0, j0, cells)) patch.low = kNaN;
  return patch;
}

}  // namespace

BlockPatches make_patches(const HeightBlock& block) {
  BlockPatches out;
  for (int j = 0; j < 16; ++j) {
    for (int i = 0; i < 16; ++i) out.fine[static_cast<std::size_t>(j * 16 + i)] = make_patch(block, i * 16, j * 16, 16);
  }
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) out.middle[static_cast<std::size_t>(j * 4 + i)] = make_patch(block, i * 64, j * 64, 64);
  }
  out.whole = make_patch(block, 0, 0, 256);
  return out;
}

}  // namespace tintree::simplify
