#include "codec/range_coder.h"

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "codec/quick_bit_model.h"

namespace tintree::codec {
namespace {

template <typename Model>
class RangeCoder : public testing::Test {};
using Models = testing::Types<BitModel, QuickBitModel>;
TYPED_TEST_SUITE(RangeCoder, Models);

TYPED_TEST(RangeCoder, KeepsBitsOfEveryProbability) {
  std::mt19937 random(1);
  for (const unsigned per_mille : {0U, 1U, 20U, 500U, 999U, 1000U}) {
    std::vector<bool> bits(5000);
    for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = random() % 1000 < per_mille;
    RangeEncoder encoder;
    TypeParam model;
    for (const bool b : bits) {
      encoder.bit(model, b);
      encoder.bit(b != (bits.size() % 3 == 0));
    }
    const std::vector<std::byte> bytes = encoder.finish();
    RangeDecoder decoder(bytes);
    TypeParam again;
    for (const bool b : bits) {
      ASSERT_EQ(decoder.bit(again), b);
      ASSERT_EQ(decoder.bit(), b != (bits.size() % 3 == 0));
    }
  }
}

TYPED_TEST(RangeCoder, CostsWhatTheBitsAreWorth) {
  std::mt19937 random(2);
  RangeEncoder encoder;
  TypeParam model;
  for (int i = 0; i < 20000; ++i) encoder.bit(model, random() % 10 == 0);
  const double entropy = -0.1 * std::log2(0.1) - 0.9 * std::log2(0.9);
  EXPECT_NEAR(static_cast<double>(encoder.finish().size()), entropy * 20000 / 8, 0.06 * entropy * 20000 / 8);
}

TYPED_TEST(RangeCoder, CarriesThroughLongRunsOfOnes) {
  // Improbable ones drive the code to its range's upper end.
  for (int ones = 1; ones < 40; ++ones) {
    RangeEncoder encoder;
    TypeParam sure;
    for (int i = 0; i < 300; ++i) sure.learn(false);
    TypeParam model = sure;
    for (int i = 0; i < ones; ++i) encoder.bit(true);
    encoder.bit(model, true);
    for (int i = 0; i < 5; ++i) encoder.bit(model, false);
    const auto bytes = encoder.finish();
    RangeDecoder decoder(bytes);
    model = sure;
    for (int i = 0; i < ones; ++i) ASSERT_TRUE(decoder.bit());
    ASSERT_TRUE(decoder.bit(model));
    for (int i = 0; i < 5; ++i) ASSERT_FALSE(decoder.bit(model));
  }
}

TYPED_TEST(RangeCoder, NoBitIsFree) {
  for (const bool b : {false, true}) {
    TypeParam model;
    for (int i = 0; i < 100000; ++i) model.learn(b);
    const double likely = b ? 65536.0 - model.zero() : model.zero();
    EXPECT_GT(-std::log2(likely / 65536), 8.0 / kMostBitsPerByte);
  }
}

TEST(QuickBitModel, LearnsFromFewBits) {
  const auto cost = [](auto model) {
    RangeEncoder encoder;
    for (int i = 0; i < 60; ++i) encoder.bit(model, false);
    return encoder.finish(0).size();
  };
  EXPECT_LT(cost(QuickBitModel{}), cost(BitModel{}));
}

TEST(NumberModel, KeepsNumbersOfEverySize) {
  std::mt19937_64 random(3);
  std::vector<std::int64_t> numbers{0, 1, -1, 2, -2, 3, (std::int64_t{1} << 52), -(std::int64_t{1} << 52)};
  for (int i = 0; i < 3000; ++i) {
    const auto size = static_cast<std::int64_t>(random() >> (11 + random() % 53));
    numbers.push_back(i % 2 == 0 ? size : -size);
  }
  RangeEncoder encoder;
  NumberModel model;
  for (const std::int64_t n : numbers) model.code(encoder, n);
  const auto bytes = encoder.finish();
  RangeDecoder decoder(bytes);
  NumberModel again;
  for (const std::int64_t n : numbers) ASSERT_EQ(again.code(decoder, 0), n);
}

}  // namespace
}  // namespace tintree::codec
