#include "codec/bc4_block.h"

#include <algorithm>
#include <cmath>

namespace tintree::codec {
namespace {

constexpr float kMost = 127;

/// The values that a block offers, -127 to 127, in the order of their codes.
std::array<float, 8> palette(int first, int second) {
  std::array<float, 8> out{};
  const auto a = static_cast<float>(first);
  const auto b = static_cast<float>(second);
  out[0] = a;
  out[1] = b;
  if (first > second) {
    for (int k = 1; k < 7; ++k)
      out[static_cast<std::size_t>(k) + 1] = (static_cast<float>(7 - k) * a + static_cast<float>(k) * b) / 7;
  } else {
    for (int k = 1; k < 5; ++k)
      out[static_cast<std::size_t>(k) + 1] = (static_cast<float>(5 - k) * a + static_cast<float>(k) * b) / 5;
    out[6] = -kMost;
    out[7] = kMost;
  }
  return out;
}

struct Fit {
  int first = 0;
  int second = 0;
  std::array<std::uint8_t, 16> choice{};
  float error = 0;
};

Fit choose(const ValueBlock& scaled, int first, int second) {
  Fit fit{first, second, {}, 0};
  const std::array<float, 8> offered = palette(first, second);
  for (std::size_t i = 0; i < 16; ++i) {
    float least = 1e9F;
    for (std::size_t p = 0; p < 8; ++p) {
      const float off = std::abs(scaled[i] - offered[p]);
      if (off >= least) continue;
      least = off;
      fit.choice[i] = static_cast<std::uint8_t>(p);
    }
    fit.error += least * least;
  }
  return fit;
}

/// The ends between which the choices would suit best.
Fit refine(const ValueBlock& scaled, const Fit& fit) {
  float aa = 0;
  float ab = 0;
  float bb = 0;
  float at = 0;
  float bt = 0;
  for (std::size_t i = 0; i < 16; ++i) {
    const int code = fit.choice[i];
    const float b = code == 0 ? 0 : code == 1 ? 1 : static_cast<float>(code - 1) / 7;
    const float a = 1 - b;
    aa += a * a;
    ab += a * b;
    bb += b * b;
    at += a * scaled[i];
    bt += b * scaled[i];
  }
  const float det = aa * bb - ab * ab;
  if (det < 1e-4F) return fit;
  const auto end = [](float v) { return static_cast<int>(std::lround(std::clamp(v, -kMost, kMost))); };
  const int first = end((at * bb - bt * ab) / det);
  const int second = end((bt * aa - at * ab) / det);
  return first > second ? choose(scaled, first, second) : fit;
}

}  // namespace

Bc4Block encode_bc4(const ValueBlock& values) {
  ValueBlock scaled{};
  std::ranges::transform(values, scaled.begin(), [](float v) { return std::clamp(v, -1.0F, 1.0F) * kMost; });
  const auto [low, high] = std::ranges::minmax(scaled);
  Fit fit = choose(scaled, static_cast<int>(std::lround(high)), static_cast<int>(std::lround(low)));
  if (fit.first > fit.second) {
    const Fit refined = refine(scaled, fit);
    if (refined.error < fit.error) fit = refined;
  }
  Bc4Block out{};
  out[0] = static_cast<std::byte>(static_cast<std::int8_t>(fit.first));
  out[1] = static_cast<std::byte>(static_cast<std::int8_t>(fit.second));
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < 16; ++i) bits |= std::uint64_t{fit.choice[i]} << (3 * i);
  for (std::size_t k = 0; k < 6; ++k) out[2 + k] = static_cast<std::byte>((bits >> (8 * k)) & 255U);
  return out;
}

ValueBlock decode_bc4(const Bc4Block& block) {
  // -128 means the same as -127.
  const auto end = [&block](std::size_t i) {
    return std::max(-127, static_cast<int>(static_cast<std::int8_t>(std::to_integer<std::uint8_t>(block[i]))));
  };
  const std::array<float, 8> offered = palette(end(0), end(1));
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < 6; ++k) bits |= std::to_integer<std::uint64_t>(block[2 + k]) << (8 * k);
  ValueBlock out{};
  for (std::size_t i = 0; i < 16; ++i) out[i] = offered[(bits >> (3 * i)) & 7U] / kMost;
  return out;
}

}  // namespace tintree::codec
