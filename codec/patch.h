#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace tintree::codec {

/// Samples that a patch holds beyond its own on every side (Yusov & Turlapov 2008, formulas 2 and 3).
inline constexpr int kPatchMargin = 2;
/// A layer's height where there is no surface.
inline constexpr std::int64_t kNoHeight = std::numeric_limits<std::int64_t>::min();

/// No height of ours is farther from 0; damaged bytes may lead there.
inline constexpr std::int64_t kFarthestHeight = std::int64_t{1} << 50;

/// A square of one layer of the pyramid: n x n samples and their margin, row-major, north row first, as whole numbers
/// of some unit of height. The samples of the next coarser layer lie in the middles of four of these.
struct Patch {
  int side = 0;  ///< n + 2 kPatchMargin
  std::vector<std::int64_t> heights;

  Patch() = default;
  Patch(int s, std::int64_t height)
      : side(s), heights(static_cast<std::size_t>(s) * static_cast<std::size_t>(s), height) {}
  std::int64_t& at(int x, int y) { return heights[index(x, y)]; }
  std::int64_t at(int x, int y) const { return heights[index(x, y)]; }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x);
  }
};

/// A child's patch by bilinear interpolation of its parent's (section 3.4): what a graphics card samples. The parent
/// has no missing heights, and its unit is `units` of the child's.
Patch predict_patch(const Patch& parent, int quadrant, int units);

}  // namespace tintree::codec
