#include "simplify/split_flags.h"

#include <cstdint>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

TEST(SplitFlags, RankTheirBits) {
  SplitFlags flags(512);
  std::set<std::pair<std::int64_t, std::int64_t>> set;
  for (int k = 0; k < 3000; ++k) {
    const auto x = static_cast<std::int64_t>(test::noise(k, 1) * 513);
    const auto y = static_cast<std::int64_t>(test::noise(k, 2) * 513);
    EXPECT_EQ(flags.set(x, y), set.insert({x, y}).second);
  }
  EXPECT_EQ(flags.number(), static_cast<std::int32_t>(set.size()));
  std::set<std::int32_t> ranks;
  for (std::int64_t y = 0; y <= 512; ++y) {
    for (std::int64_t x = 0; x <= 512; ++x) {
      EXPECT_EQ(flags.get(x, y), set.contains({x, y}));
      if (flags.get(x, y)) ranks.insert(flags.rank(x, y));
    }
  }
  EXPECT_EQ(ranks.size(), set.size());
  EXPECT_EQ(*ranks.begin(), 0);
  EXPECT_EQ(*ranks.rbegin(), static_cast<std::int32_t>(set.size()) - 1);
}

}  // namespace
}  // namespace tintree::simplify
