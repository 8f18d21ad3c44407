#include "apps/audit/border.h"

#include <gtest/gtest.h>

#include "tests/apps/audit/measure_support.h"

namespace tintree::test {
namespace {

using audit::compare_sides;
using audit::SideLine;

TEST(Border, NeighboursOfAValidTreeAgree) {
  const RasterFixture dem({.columns = 40, .rows = 35},
                          [](int c, int r) { return c == 16 && r == 20 ? kMissing : hills(c, r); });
  const TestTree tree = make_regular_tree(dem.path, {.tile_cells = 16});
  const auto sides = [&](std::uint32_t x, std::uint32_t y) {
    const codec::TileId id{tree.manifest.layout.leaf_level, x, y};
    return audit::side_lines(audit::place(tree.manifest.layout, id, tree.mesh(id)));
  };
  EXPECT_EQ(sides(0, 0)[audit::kEast].size(), 16U);
  EXPECT_FALSE(compare_sides(sides(0, 0)[audit::kEast], sides(1, 0)[audit::kWest]));
  EXPECT_FALSE(compare_sides(sides(0, 0)[audit::kSouth], sides(0, 1)[audit::kNorth]));
  EXPECT_FALSE(compare_sides(sides(0, 1)[audit::kEast], sides(1, 1)[audit::kWest]));
  // Cut by the raster's end: no side there.
  EXPECT_TRUE(sides(2, 0)[audit::kEast].empty());
}

TEST(Border, FindsADifferentHeight) {
  const SideLine one{{0, 8, 5, 6}, {8, 16, 6, 7}};
  SideLine other = one;
  other[0].end_height = other[1].begin_height = 9;
  const auto fault = compare_sides(one, other);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->count, 2U);
  EXPECT_EQ(fault->height_difference, 3);
}

TEST(Border, FindsAVertexThatOneSideLacks) {
  const SideLine one{{0, 8, 5, 5}, {8, 16, 5, 5}};
  const SideLine other{{0, 16, 5, 5}};
  EXPECT_TRUE(compare_sides(one, other));
  EXPECT_TRUE(compare_sides(other, one));
}

TEST(Border, IgnoresWhatFacesAHole) {
  const SideLine one{{0, 8, 5, 6}, {8, 16, 6, 7}, {16, 24, 7, 8}};
  EXPECT_FALSE(compare_sides(one, {{8, 16, 6, 7}}));
  EXPECT_FALSE(compare_sides(one, {}));
  EXPECT_FALSE(compare_sides({{0, 8, 1, 2}}, {{8, 16, 3, 4}}));
}

}  // namespace
}  // namespace tintree::test
