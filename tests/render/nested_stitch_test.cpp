#include "render/nested_stitch.h"

#include <algorithm>
#include <map>
#include <utility>

#include <gtest/gtest.h>

namespace tintree::render {
namespace {

TEST(Stitch, FillsBetweenTwoLines) {
  const std::vector<cache::BorderVertex> one{{0, 10}, {4, 11}, {8, 12}};
  const std::vector<cache::BorderVertex> other{{0, 20}, {8, 21}};
  const auto triangles = stitch(one, other);
  // As many as both have edges, each with a corner on either line.
  EXPECT_EQ(triangles.size(), 3U);
  std::map<std::pair<bool, std::uint32_t>, int> uses;
  for (const auto& t : triangles) {
    EXPECT_FALSE(t[0].other);
    EXPECT_TRUE(t[1].other);
    for (const StitchCorner& c : t) ++uses[{c.other, c.vertex}];
  }
  EXPECT_EQ(uses.size(), 5U);
}

TEST(Stitch, OverlapsItsNeighbours) {
  std::vector<cache::BorderVertex> other;
  for (std::uint32_t i = 0; i <= 16; ++i) other.push_back({4 * i, i});
  const std::vector<cache::BorderVertex> one{{16, 100}, {22, 101}, {32, 102}};
  std::uint32_t first = 99;
  std::uint32_t last = 0;
  for (const auto& t : stitch(one, other)) {
    for (const StitchCorner& c : t) {
      if (!c.other) continue;
      first = std::min(first, c.vertex);
      last = std::max(last, c.vertex);
    }
  }
  EXPECT_EQ(first, 3U);
  EXPECT_EQ(last, 9U);
}

TEST(Stitch, EndsWhereTheOtherLineDoes) {
  std::vector<cache::BorderVertex> one;
  for (std::uint32_t i = 0; i <= 16; ++i) one.push_back({4 * i, i});
  const std::vector<cache::BorderVertex> other{{16, 100}, {22, 101}, {32, 102}};
  std::uint32_t first = 99;
  std::uint32_t last = 0;
  for (const auto& t : stitch(one, other)) {
    for (const StitchCorner& c : t) {
      if (c.other) continue;
      first = std::min(first, c.vertex);
      last = std::max(last, c.vertex);
    }
  }
  EXPECT_EQ(first, 4U);
  EXPECT_EQ(last, 8U);
  const std::vector<cache::BorderVertex> beyond{{64, 103}, {80, 104}};
  EXPECT_TRUE(stitch(one, beyond).empty());
}

TEST(Stitch, NeedsTwoLines) {
  EXPECT_TRUE(stitch({}, {}).empty());
  const std::vector<cache::BorderVertex> one{{0, 1}};
  EXPECT_TRUE(stitch(one, one).empty());
}

}  // namespace
}  // namespace tintree::render
