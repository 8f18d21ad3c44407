#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "codec/bc1_block.h"
#include "codec/bc4_block.h"

namespace tintree::codec {
namespace {

using Real = std::array<double, 4>;

/// Texel `i` of a BC1 block in real numbers, 0 to 1, as section 18.1 of the Khronos Data Format Specification says it.
Real specified_bc1(const Bc1Block& block, int i) {
  const auto byte = [&block](int k) { return static_cast<unsigned>(block[static_cast<std::size_t>(k)]); };
  const unsigned first = byte(0) + 256 * byte(1);
  const unsigned second = byte(2) + 256 * byte(3);
  const auto color = [](unsigned c) { return Real{(c / 2048) / 31.0, (c / 32 % 64) / 63.0, (c % 32) / 31.0, 1}; };
  const unsigned code = byte(4 + i / 4) / (1U << (2 * (i % 4))) % 4;
  const auto mix = [&](double share) {
    Real out{0, 0, 0, 1};
    for (std::size_t k = 0; k < 3; ++k) out[k] = (1 - share) * color(first)[k] + share * color(second)[k];
    return out;
  };
  if (code == 0) return color(first);
  if (code == 1) return color(second);
  if (first > second) return mix(code == 2 ? 1.0 / 3 : 2.0 / 3);
  return code == 2 ? mix(0.5) : Real{0, 0, 0, 0};
}

/// Value `i` of a signed BC4 block, as section 18.4 says it.
double specified_bc4(const Bc4Block& block, int i) {
  const auto end = [&block](std::size_t k) {
    return std::max(-127.0, static_cast<double>(static_cast<signed char>(block[k]))) / 127;
  };
  const double a = end(0);
  const double b = end(1);
  unsigned code = 0;
  for (int bit = 0; bit < 3; ++bit) {
    const int at = 3 * i + bit;
    const auto byte = static_cast<unsigned>(block[static_cast<std::size_t>(2 + at / 8)]);
    code += (byte / (1U << (at % 8)) % 2) << bit;
  }
  if (code == 0) return a;
  if (code == 1) return b;
  if (static_cast<signed char>(block[0]) > static_cast<signed char>(block[1]))
    return ((8 - code) * a + (code - 1) * b) / 7;
  if (code == 6) return -1;
  if (code == 7) return 1;
  return ((6 - code) * a + (code - 1) * b) / 5;
}

template <typename Block>
Block random_block(std::mt19937& random) {
  Block block{};
  for (std::byte& b : block) b = static_cast<std::byte>(random() & 255U);
  return block;
}

TEST(Bc1Block, DecodesAsSpecified) {
  std::mt19937 random(1);
  for (int round = 0; round < 2000; ++round) {
    const auto block = random_block<Bc1Block>(random);
    const ColorBlock decoded = decode_bc1(block);
    for (int i = 0; i < 16; ++i) {
      const Real expected = specified_bc1(block, i);
      // Eight bits, after the ends were widened to eight bits too.
      for (std::size_t k = 0; k < 4; ++k) ASSERT_NEAR(decoded[static_cast<std::size_t>(i)][k], 255 * expected[k], 1.3);
    }
  }
}

TEST(Bc4Block, DecodesAsSpecified) {
  std::mt19937 random(2);
  for (int round = 0; round < 2000; ++round) {
    const auto block = random_block<Bc4Block>(random);
    const ValueBlock decoded = decode_bc4(block);
    for (int i = 0; i < 16; ++i) ASSERT_NEAR(decoded[static_cast<std::size_t>(i)], specified_bc4(block, i), 1e-5);
  }
}

TEST(Bc1Block, KeepsEveryPlainColorWithinTwoSteps) {
  for (int v = 0; v < 256; ++v) {
    const auto u = static_cast<std::uint8_t>(v);
    const auto w = static_cast<std::uint8_t>(255 - v);
    ColorBlock texels{};
    texels.fill({u, w, 128, 255});
    for (const auto& t : decode_bc1(encode_bc1(texels))) {
      ASSERT_NEAR(t[0], u, 2);
      ASSERT_NEAR(t[1], w, 2);
      ASSERT_NEAR(t[2], 128, 2);
      ASSERT_EQ(t[3], 255);
    }
  }
}

TEST(Bc1Block, KeepsFourColorsOnALine) {
  ColorBlock texels{};
  for (std::size_t i = 0; i < 16; ++i) {
    const auto step = static_cast<std::uint8_t>(i % 4);
    texels[i] = {static_cast<std::uint8_t>(33 * step), static_cast<std::uint8_t>(255 - 81 * step), 66, 255};
  }
  const ColorBlock decoded = decode_bc1(encode_bc1(texels));
  for (std::size_t i = 0; i < 16; ++i) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(decoded[i][k], texels[i][k], 6);
  }
}

TEST(Bc1Block, KeepsWhatIsCoveredAndWhatIsNot) {
  std::mt19937 random(3);
  for (int round = 0; round < 500; ++round) {
    ColorBlock texels{};
    for (auto& t : texels) {
      for (std::size_t k = 0; k < 3; ++k) t[k] = static_cast<std::uint8_t>(random() & 255U);
      t[3] = (random() & 1U) != 0 ? 255 : 0;
    }
    if (round == 0) texels.fill({9, 9, 9, 0});
    const ColorBlock decoded = decode_bc1(encode_bc1(texels));
    for (std::size_t i = 0; i < 16; ++i) ASSERT_EQ(decoded[i][3], texels[i][3]);
  }
}

/// No pair of ends that random search finds does much better.
TEST(Bc1Block, ComesNearTheBestOfManyTries) {
  std::mt19937 random(4);
  double own = 0;
  double best_found = 0;
  for (int round = 0; round < 30; ++round) {
    ColorBlock texels{};
    const int slope = static_cast<int>(random() % 12);
    for (std::size_t i = 0; i < 16; ++i) {
      const int v = 60 + slope * static_cast<int>(i) + static_cast<int>(random() % 20);
      texels[i] = {static_cast<std::uint8_t>(v), static_cast<std::uint8_t>(v / 2 + 20),
                   static_cast<std::uint8_t>(200 - v / 2), 255};
    }
    const auto error_of = [&texels](const Bc1Block& block) {
      const ColorBlock decoded = decode_bc1(block);
      double sum = 0;
      for (std::size_t i = 0; i < 16; ++i) {
        for (std::size_t k = 0; k < 3; ++k) sum += std::pow(decoded[i][k] - texels[i][k], 2);
      }
      return sum;
    };
    const Bc1Block coded = encode_bc1(texels);
    const double error = error_of(coded);
    double best = error;
    for (int attempt = 0; attempt < 300; ++attempt) {
      Bc1Block other = coded;
      for (std::size_t k = 0; k < 4; ++k) {
        if (random() % 3 == 0) other[k] = static_cast<std::byte>(static_cast<unsigned>(other[k]) + random() % 3 - 1);
      }
      for (std::size_t i = 0; i < 16; ++i) {
        double least = 1e9;
        std::byte choice{};
        for (unsigned code = 0; code < 4; ++code) {
          Bc1Block tried = other;
          tried[4 + i / 4] = static_cast<std::byte>(code << (2 * (i % 4)));
          const Real c = specified_bc1(tried, static_cast<int>(i));
          double off = c[3] == 0 ? 1e9 : 0;
          for (std::size_t k = 0; k < 3; ++k) off += std::pow(255 * c[k] - texels[i][k], 2);
          if (off < least) choice = tried[4 + i / 4];
          least = std::min(least, off);
        }
        const auto keep = static_cast<std::byte>(~(3U << (2 * (i % 4))));
        other[4 + i / 4] = (other[4 + i / 4] & keep) | choice;
      }
      best = std::min(best, error_of(other));
    }
    own += error;
    best_found += best;
  }
  EXPECT_LT(own, 1.35 * best_found);
}

TEST(Bc4Block, ErrsByHalfAStepOfTheRangeAtMostOnRamps) {
  std::mt19937 random(5);
  for (int round = 0; round < 200; ++round) {
    const double low = -1 + 1.5 * static_cast<double>(random() % 1000) / 1000;
    const double range = (1 - low) * static_cast<double>(random() % 1000) / 1000;
    ValueBlock values{};
    for (std::size_t i = 0; i < 16; ++i) values[i] = static_cast<float>(low + range * static_cast<double>(i) / 15);
    const ValueBlock decoded = decode_bc4(encode_bc4(values));
    for (std::size_t i = 0; i < 16; ++i) ASSERT_NEAR(decoded[i], values[i], range / 14 + 1.0 / 127);
  }
}

TEST(Bc4Block, KeepsWhatItsEndsCanSay) {
  for (const int v : {-127, -64, 0, 1, 127}) {
    ValueBlock values{};
    values.fill(static_cast<float>(v) / 127);
    EXPECT_EQ(decode_bc4(encode_bc4(values)), values);
  }
}

}  // namespace
}  // namespace tintree::codec
