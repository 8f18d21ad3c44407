#include "codec/patch_residual.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace tintree::codec {

std::optional<PatchResidual> make_patch_residual(const Patch& patch, const Patch& prediction) {
  const auto fits = [](std::int64_t h) { return h > -kFarthestOnCard && h < kFarthestOnCard; };
  if (!std::ranges::all_of(patch.heights, fits) || !std::ranges::all_of(prediction.heights, fits)) return std::nullopt;
  std::vector<std::int64_t> residuals(patch.heights.size());
  std::ranges::transform(patch.heights, prediction.heights, residuals.begin(), std::minus());
  const auto [low, high] = std::ranges::minmax(residuals);
  std::int64_t step = 0;
  for (const std::int64_t r : residuals) step = std::gcd(step, r - low);
  PatchResidual out{patch.side, static_cast<std::int32_t>(low), static_cast<std::int32_t>(step), {}, {}};
  if (step == 0) {
    out.step = 1;
    return out;
  }
  const std::int64_t highest = (high - low) / step;
  if (highest > std::numeric_limits<std::uint16_t>::max()) return std::nullopt;
  const auto put = [&, low = low]<typename Number>(std::vector<Number>& numbers) {
    numbers.reserve(residuals.size());
    for (const std::int64_t r : residuals) numbers.push_back(static_cast<Number>((r - low) / step));
  };
  if (highest <= std::numeric_limits<std::uint8_t>::max()) {
    put(out.numbers);
  } else {
    put(out.wide_numbers);
  }
  return out;
}

}  // namespace tintree::codec
