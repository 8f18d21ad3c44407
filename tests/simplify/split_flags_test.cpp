#include "simplify/split_flags.h"

#include <cstdint>
#include <random>
#include <set>
#include <utility>

#include <gtest/gtest.h>

namespace tintree::simplify {
namespace {

TEST(SplitFlags, RankTheirBits) {
  SplitFlags flags(512);
  std::set<std::pair<std::int64_t, std::int64_t>> set;
  std::mt19937 random(1);
  for (int k = 0; k < 3000; ++k) {
    const std::int64_t x = random() % 513;
    const std::int64_t y = random() % 513;
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

TEST(SplitFlags, VisitWhatIsSet) {
  SplitFlags flags(200);
  std::mt19937 random(2);
  std::set<std::pair<std::int64_t, std::int64_t>> set;
  for (int k = 0; k < 2000; ++k) {
    const std::int64_t x = random() % 201;
    const std::int64_t y = random() % 201;
    if (k % 3 == 0) {
      flags.clear(x, y);
      set.erase({x, y});
    } else {
      flags.set(x, y);
      set.insert({x, y});
    }
  }
  std::set<std::pair<std::int64_t, std::int64_t>> visited;
  flags.for_each([&](std::int64_t x, std::int64_t y) { EXPECT_TRUE(visited.insert({x, y}).second); });
  EXPECT_EQ(visited, set);
}

}  // namespace
}  // namespace tintree::simplify
