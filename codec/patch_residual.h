#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/wavelet_patch.h"

namespace tintree::codec {

/// What a patch adds to its prediction, as a graphics card takes it (Yusov & Turlapov 2008, section 4: the card
/// predicts, and is sent the quantised residuals alone): a sample's residual is low + step times its number.
struct PatchResidual {
  int side = 0;
  std::int32_t low = 0;
  std::int32_t step = 1;
  /// The numbers, row-major as in Patch: in 8 bits where all fit, else in 16; the other list is empty. Both are where
  /// all are 0.
  std::vector<std::uint8_t> numbers;
  std::vector<std::uint16_t> wide_numbers;

  std::size_t bytes() const { return numbers.size() + 2 * wide_numbers.size(); }
};

/// Heights of a patch that a card's 32 bits predict from without overflow lie nearer to 0.
inline constexpr std::int64_t kFarthestOnCard = std::int64_t{1} << 26;

/// The difference of two patches of one size, exactly. Nothing where 16 bits do not hold it, or where heights are
/// beyond kFarthestOnCard.
std::optional<PatchResidual> make_patch_residual(const Patch& patch, const Patch& prediction);

}  // namespace tintree::codec
