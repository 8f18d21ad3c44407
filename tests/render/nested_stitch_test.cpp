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

std::vector<cache::BorderVertex> long_line() {
  std::vector<cache::BorderVertex> out;
  for (std::uint32_t i = 0; i <= 16; ++i) out.push_back({4 * i, i});
  return out;
}

/// The first and the last vertex of one of the lines that are used.
std::pair<std::uint32_t, std::uint32_t> used(const std::vector<std::array<StitchCorner, 3>>& triangles, bool other) {
  std::pair<std::uint32_t, std::uint32_t> out{99, 0};
  for (const auto& t : triangles) {
    for (const StitchCorner& c : t) {
      if (c.other == other) out = {std::min(out.first, c.vertex), std::max(out.second, c.vertex)};
    }
  }
  return out;
}

const std::vector<cache::BorderVertex> kShort{{16, 100}, {22, 101}, {32, 102}};

TEST(Stitch, OverlapsItsNeighbours) { EXPECT_EQ(used(stitch(kShort, long_line()), true), std::pair(3U, 9U)); }

TEST(Stitch, EndsWhereTheOtherLineDoes) {
  EXPECT_EQ(used(stitch(long_line(), kShort), false), std::pair(4U, 8U));
  const std::vector<cache::BorderVertex> beyond{{64, 103}, {80, 104}};
  EXPECT_TRUE(stitch(long_line(), beyond).empty());
}

TEST(Stitch, NeedsTwoLines) {
  EXPECT_TRUE(stitch({}, {}).empty());
  const std::vector<cache::BorderVertex> one{{0, 1}};
  EXPECT_TRUE(stitch(one, one).empty());
}

}  // namespace
}  // namespace tintree::render
