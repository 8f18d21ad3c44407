#include "simplify/srgb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tintree::simplify {
namespace {

constexpr std::size_t kSteps = 1 << 14;

std::array<float, 256> make_linear() {
  std::array<float, 256> out{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double s = static_cast<double>(i) / 255;
    out[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
  }
  return out;
}

std::array<std::uint8_t, kSteps + 1> make_srgb() {
  std::array<std::uint8_t, kSteps + 1> out{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double l = static_cast<double>(i) / kSteps;
    const double s = l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
    out[i] = static_cast<std::uint8_t>(std::lround(255 * s));
  }
  return out;
}

}  // namespace

float linear_of(std::uint8_t srgb) {
  static const std::array<float, 256> table = make_linear();
  return table[srgb];
}

std::uint8_t srgb_of(float linear) {
  static const auto table = make_srgb();
  return table[static_cast<std::size_t>(std::lround(std::clamp(linear, 0.0F, 1.0F) * static_cast<float>(kSteps)))];
}

}  // namespace tintree::simplify
