#pragma once

#include <cstdint>

namespace tintree::simplify {

/// Between sRGB bytes and linear light, 0 to 1 (IEC 61966-2-1). Pictures are filtered in linear light.
float linear_of(std::uint8_t srgb);
/// The nearest byte; light is cut off to 0 to 1. Right to a tenth of a step before rounding.
std::uint8_t srgb_of(float linear);

}  // namespace tintree::simplify
