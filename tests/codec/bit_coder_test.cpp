#include "codec/bit_coder.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tintree::codec {
namespace {

TEST(BitCoder, BitsComeBackAndTakeAboutTheirEntropy) {
  for (const double chance : {0.5, 0.1, 0.01}) {
    std::mt19937 random(7);
    std::bernoulli_distribution one(chance);
    std::vector<bool> bits(20000);
    for (auto&& bit : bits) bit = one(random);
    BitEncoder encoder;
    BitModel model;
    for (const bool bit : bits) encoder.put(model, bit);
    const std::vector<std::byte> bytes = encoder.finish();
    const double entropy = -chance * std::log2(chance) - (1 - chance) * std::log2(1 - chance);
    EXPECT_LT(static_cast<double>(8 * bytes.size()), 1.2 * entropy * static_cast<double>(bits.size()));

    BitDecoder decoder(bytes);
    BitModel again;
    for (std::size_t i = 0; i < bits.size(); ++i) ASSERT_EQ(decoder.get(again), bits[i]) << i;
    EXPECT_FALSE(decoder.exhausted());
  }
}

TEST(BitCoder, IntegersOfAllSizesComeBack) {
  std::mt19937_64 random(3);
  std::vector<std::int64_t> numbers{0, 1, -1, std::int64_t{1} << 61, -(std::int64_t{1} << 61)};
  for (int digits = 1; digits < 62; ++digits) {
    for (int i = 0; i < 30; ++i) {
      const auto size = static_cast<std::int64_t>(random() >> (64 - digits));
      numbers.push_back(i % 2 == 0 ? size : -size);
    }
  }
  BitEncoder encoder;
  IntegerModel model;
  for (const std::int64_t number : numbers) model.put(encoder, number);
  const auto bytes = encoder.finish();
  BitDecoder decoder(bytes);
  IntegerModel again;
  for (const std::int64_t number : numbers) ASSERT_EQ(again.get(decoder), number);
  EXPECT_FALSE(decoder.exhausted());
}

TEST(BitCoder, ReadsNothingBehindTheEndAndSaysSo) {
  BitDecoder decoder({});
  BitModel model;
  for (int i = 0; i < 10000; ++i) static_cast<void>(decoder.get(model));
  EXPECT_TRUE(decoder.exhausted());
}

}  // namespace
}  // namespace tintree::codec
