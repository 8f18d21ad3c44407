#include "apps/audit/level_gap.h"

#include <gtest/gtest.h>

namespace tintree::audit {
namespace {

TEST(LevelGap, IsFoundAtAVertexOfEitherLine) {
  // A straight line at 0 m, and one with a peak of 7 steps of half a metre at position 24 eighths.
  const SideLine coarse{{0, 64, 0, 0}};
  const SideLine fine{{0, 24, 0, 7}, {24, 64, 7, 0}};
  for (const LineGap& gap : {widest_gap(coarse, 4, fine, 0.5), widest_gap(fine, 0.5, coarse, 4)}) {
    EXPECT_DOUBLE_EQ(gap.gap_m, 3.5);
    EXPECT_DOUBLE_EQ(gap.position, 3);
  }
}

TEST(LevelGap, DoesNotCountWhereOneLineHasAHole) {
  const SideLine coarse{{0, 8, 10, 10}, {40, 64, 2, 2}};
  const SideLine fine{{16, 32, 0, 0}, {32, 48, 0, 0}, {48, 56, 1, 1}};
  EXPECT_DOUBLE_EQ(widest_gap(coarse, 1, fine, 1).gap_m, 2);
  EXPECT_DOUBLE_EQ(widest_gap(coarse, 1, {}, 1).gap_m, 0);
}

TEST(LevelGap, FindsTheTileBehindASide) {
  LevelLines coarse;
  coarse.level = coarse.halvings = 1;
  coarse.tiles_x = 2;
  coarse.east.resize(4);
  coarse.south.resize(4);
  const auto behind = [&](const codec::TileId& fine, Side side) { return coarse_neighbour(coarse, fine, 3, side); };
  // Level 3: four tiles across one of level 1.
  EXPECT_EQ(behind({3, 4, 1}, kWest)->tile, (codec::TileId{1, 0, 0}));
  EXPECT_EQ(behind({3, 4, 1}, kWest)->line, &coarse.east[0]);
  EXPECT_EQ(behind({3, 3, 5}, kEast)->tile, (codec::TileId{1, 1, 1}));
  EXPECT_EQ(behind({3, 3, 5}, kEast)->line, &coarse.east[2]);
  EXPECT_EQ(behind({3, 5, 4}, kNorth)->tile, (codec::TileId{1, 1, 0}));
  EXPECT_EQ(behind({3, 5, 3}, kSouth)->line, &coarse.south[1]);
  for (const Side side : {kWest, kNorth, kEast, kSouth}) EXPECT_FALSE(behind({3, 1, 2}, side)) << "inside";
  EXPECT_FALSE(behind({3, 0, 0}, kWest));
  EXPECT_FALSE(behind({3, 7, 0}, kEast));
  EXPECT_FALSE(behind({3, 7, 7}, kSouth));
  // A finer level on the same squares.
  EXPECT_EQ(coarse_neighbour(coarse, {2, 1, 0}, 1, kWest)->tile, (codec::TileId{1, 0, 0}));
  EXPECT_EQ(coarse_neighbour(coarse, {2, 1, 0}, 1, kWest)->line, &coarse.east[0]);
  EXPECT_FALSE(coarse_neighbour(coarse, {2, 1, 0}, 1, kEast));
}

}  // namespace
}  // namespace tintree::audit
