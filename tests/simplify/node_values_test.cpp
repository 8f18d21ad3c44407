#include "simplify/node_values.h"

#include <cmath>

#include <gtest/gtest.h>

#include "simplify/srgb.h"

namespace tintree::simplify {
namespace {

template <typename Value>
NodeValues make(int side, const Value& value) {
  NodeValues out(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) out.at(x, y) = value(x, y);
  }
  return out;
}

class HalveTest : public testing::TestWithParam<HalvingFilter> {};

INSTANTIATE_TEST_SUITE_P(All, HalveTest, testing::Values(kSharpHalving, kMeanHalving));

TEST_P(HalveTest, KeepsWhatIsConstant) {
  const auto out = halve(make(31, [](int, int) { return std::array{0.25F, -0.5F, 1.0F, 1.0F}; }), GetParam());
  EXPECT_EQ(out.width, (31 - 2 * GetParam().reach + 1) / 2);
  for (const auto& v : out.values) {
    EXPECT_NEAR(v[0], 0.25, 1e-6);
    EXPECT_NEAR(v[1], -0.5, 1e-6);
    EXPECT_NEAR(v[2], 1, 1e-6);
    EXPECT_NEAR(v[3], 1, 1e-6);
  }
}

/// A picture that is linear in the plane keeps its values where its nodes are kept.
TEST_P(HalveTest, KeepsWhatIsLinearInItsPlace) {
  const int reach = GetParam().reach;
  const auto out =
      halve(make(40,
                 [](int x, int y) {
                   return std::array{0.01F * static_cast<float>(x), 0.02F * static_cast<float>(y), 0.0F, 1.0F};
                 }),
            GetParam());
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      EXPECT_NEAR(out.at(x, y)[0], 0.01 * (2 * x + reach), 1e-5);
      EXPECT_NEAR(out.at(x, y)[1], 0.02 * (2 * y + reach), 1e-5);
    }
  }
}

/// The finest detail vanishes into its mean: a black and white chequerboard becomes the grey of half the light.
TEST_P(HalveTest, MakesAChequerboardGrey) {
  const auto out = halve(make(30,
                              [](int x, int y) {
                                const float v = linear_of((x + y) % 2 == 0 ? 255 : 0);
                                return std::array{v, v, v, 1.0F};
                              }),
                         GetParam());
  for (const auto& v : out.values) {
    EXPECT_NEAR(v[0], 0.5, 1e-6);
    EXPECT_EQ(srgb_of(v[0]), 188);
  }
}

TEST_P(HalveTest, LeavesOutWhatIsNotCovered) {
  const auto out = halve(make(40,
                              [](int x, int) {
                                return x < 20 ? std::array{0.5F, 0.5F, 0.5F, 1.0F} : std::array{9.0F, 9.0F, 9.0F, 0.0F};
                              }),
                         GetParam());
  for (int x = 0; x < out.width; ++x) {
    const auto& v = out.at(x, 0);
    if (v[3] >= 0.5F) {
      EXPECT_NEAR(v[0], 0.5, 1e-5) << x;
    }
    const int fine = 2 * x + GetParam().reach;
    EXPECT_EQ(v[3] >= 0.5F, fine < 20) << x;
  }
}

TEST(Srgb, GoesThereAndBack) {
  for (int v = 0; v < 256; ++v) EXPECT_EQ(srgb_of(linear_of(static_cast<std::uint8_t>(v))), v);
  EXPECT_EQ(srgb_of(-1), 0);
  EXPECT_EQ(srgb_of(7), 255);
}

}  // namespace
}  // namespace tintree::simplify
