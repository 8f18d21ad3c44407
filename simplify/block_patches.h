#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "cache/height_blocks.h"

namespace tintree::simplify {

/// A plane with the exact range of the reference surface's residuals against it over one square of
/// cells. For every point (x, y) of the square where the surface exists,
///   c + a (x - x0) + b (y - y0) + low <= S(x, y) <= c + a (x - x0) + b (y - y0) + high,
/// x and y in samples from the square's north-west corner (x0, y0), heights in metres.
/// low is NaN when a sample is missing (nothing can be concluded), and low > high when all are.
struct PlanePatch {
  float a = 0;
  float b = 0;
  float c = 0;
  float low = 0;
  float high = 0;
  /// In squares of up to 64 cells: where, from (x0, y0), a sample with either residual lies.
  std::uint8_t low_x = 0, low_y = 0;
  std::uint8_t high_x = 0, high_y = 0;

  bool empty() const { return low > high; }
};

/// Sides in cells of the squares that a block is summarised over, fine to coarse.
inline constexpr std::array<int, 3> kPatchCells{16, 64, 256};

/// The residual pyramid of one block: a PlanePatch for each of its 16-cell, 64-cell and 256-cell squares,
/// row-major. It decides most checks of large triangles without the samples (docs/accuracy.md).
struct BlockPatches {
  std::array<PlanePatch, 256> fine;
  std::array<PlanePatch, 16> middle;
  PlanePatch whole;

  /// Patch of size index `size` (of kPatchCells) that contains cell (i, j) of the block.
  const PlanePatch& at(int size, int i, int j) const {
    return size == 0   ? fine[static_cast<std::size_t>((j >> 4) * 16 + (i >> 4))]
           : size == 1 ? middle[static_cast<std::size_t>((j >> 6) * 4 + (i >> 6))]
                       : whole;
  }
};

static_assert(std::is_trivially_copyable_v<BlockPatches> && alignof(BlockPatches) <= 8 &&
              sizeof(BlockPatches) % 8 == 0);

BlockPatches make_patches(const cache::HeightBlock& block);

}  // namespace tintree::simplify
