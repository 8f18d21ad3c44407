#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace tintree::audit {

/// A square of texels with three numbers each, and whether they mean anything.
struct TexelGrid {
  int size = 0;
  std::vector<std::array<float, 3>> values;
  std::vector<bool> valid;

  TexelGrid() = default;
  explicit TexelGrid(int side)
      : size(side),
        values(static_cast<std::size_t>(side) * static_cast<std::size_t>(side)),
        valid(static_cast<std::size_t>(side) * static_cast<std::size_t>(side)) {}
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x);
  }
};

/// How well one picture lies on another.
struct PictureMatch {
  std::size_t texels = 0;  ///< Compared.
  double rms = 0;          ///< Of their differences, as they lie.
  int shift_x = 0;         ///< By how many texels the picture would have to be moved to lie best; 0 unless that is
  int shift_y = 0;         ///< better by far.
};

/// A picture against what it should be, of the same size.
PictureMatch match_pictures(const TexelGrid& picture, const TexelGrid& reference);

/// A picture of size n + 1 against its parent, of the same size: its texels under a tent of 3 x 3 against quadrant
/// `quadrant` (0 north-west, 1 north-east, 2 south-west, 3 south-east). Shifts are in the picture's texels.
PictureMatch match_parent(const TexelGrid& picture, const TexelGrid& parent, int quadrant);

}  // namespace tintree::audit
