#include "render/range_allocator.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tintree::render {
namespace {

// Against a plain row of flags: ranges never overlap, the first gap that fits is taken, and what is given back joins
// up.
TEST(RangeAllocator, HandsOutTheFirstGapThatFits) {
  constexpr std::size_t kSize = 64;
  std::mt19937 random(1);
  RangeAllocator allocator(kSize);
  std::vector<bool> taken(kSize, false);
  std::vector<std::pair<std::size_t, std::size_t>> ranges;
  const auto set = [&](std::size_t begin, std::size_t size, bool value) {
    for (std::size_t i = begin; i < begin + size; ++i) {
      ASSERT_NE(taken[i], value);
      taken[i] = value;
    }
  };
  int refused = 0;
  for (int step = 0; step < 5000; ++step) {
    if (random() % 2 == 0 && !ranges.empty()) {
      const std::size_t which = random() % ranges.size();
      allocator.give(ranges[which].first, ranges[which].second);
      set(ranges[which].first, ranges[which].second, false);
      ranges.erase(ranges.begin() + static_cast<std::ptrdiff_t>(which));
      continue;
    }
    const std::size_t size = 1 + random() % 20;
    const std::vector<bool> wanted(size, false);
    const auto first = std::ranges::search(taken, wanted).begin();
    const auto got = allocator.take(size);
    ASSERT_EQ(got.has_value(), first != taken.end());
    if (!got) {
      ++refused;
      continue;
    }
    EXPECT_EQ(*got, static_cast<std::size_t>(first - taken.begin()));
    set(*got, size, true);
    ranges.emplace_back(*got, size);
  }
  EXPECT_GT(refused, 100);
  for (const auto& [begin, size] : ranges) allocator.give(begin, size);
  EXPECT_TRUE(allocator.empty());
  EXPECT_EQ(allocator.take(kSize), 0U);
}

}  // namespace
}  // namespace tintree::render
