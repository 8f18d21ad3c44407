#include "codec/grid_frame.h"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/tree_layout.h"

namespace tintree::codec {
namespace {

using test::make_layout;

TEST(TreeLayout, LeafLevelIsTheSmallestThatCovers) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    const auto columns = static_cast<std::int64_t>(2 + random() % 100000);
    const auto rows = static_cast<std::int64_t>(2 + random() % 100000);
    const int tile = 1 << (random() % 11);
    const int level = TreeLayout::leaf_level_for(columns, rows, tile);
    const std::int64_t cells = std::max(columns, rows) - 1;
    EXPECT_GE(std::int64_t{tile} << level, cells);
    if (level > 0) {
      EXPECT_LT(std::int64_t{tile} << (level - 1), cells);
    }
  }
  EXPECT_EQ(TreeLayout::leaf_level_for(2, 2, 256), 0);
  EXPECT_EQ(TreeLayout::leaf_level_for(257, 257, 256), 0);
  EXPECT_EQ(TreeLayout::leaf_level_for(258, 2, 256), 1);
}

TEST(TreeLayout, BoundDoublesWithEveryLevelUp) {
  const TreeLayout l = make_layout(1000, 700, 16);
  EXPECT_EQ(l.bound_m(l.leaf_level), l.leaf_error_m);
  for (int level = 0; level < l.leaf_level; ++level) EXPECT_EQ(l.bound_m(level), 2 * l.bound_m(level + 1));
}

TEST(TreeLayout, WithTwoLevelsADoublingSquaresComeInPairs) {
  const TreeLayout one = make_layout(1000, 700, 16);
  const TreeLayout two = make_layout(1000, 700, 16, 2);
  ASSERT_EQ(two.leaf_level, 2 * one.leaf_level);
  for (int level = 0; level <= one.leaf_level; ++level) {
    EXPECT_EQ(two.bound_m(2 * level), one.bound_m(level));
    EXPECT_EQ(two.cells_across(2 * level), one.cells_across(level));
    EXPECT_EQ(two.halvings(2 * level), level);
    if (level == 0) continue;
    EXPECT_DOUBLE_EQ(two.bound_m(2 * level - 1), std::sqrt(2) * one.bound_m(level));
    EXPECT_EQ(two.cells_across(2 * level - 1), one.cells_across(level));
    EXPECT_EQ(two.coarsest_level(level), 2 * level - 1);
    EXPECT_EQ(two.picture_tile({2 * level, 3, 1}), (TileId{2 * level - 1, 3, 1}));
    EXPECT_EQ(two.picture_tile({2 * level - 1, 3, 1}), (TileId{2 * level - 1, 3, 1}));
    EXPECT_EQ(one.picture_tile({level, 3, 1}), (TileId{level, 3, 1}));
    EXPECT_EQ(two.is_leaf_square(2 * level - 1), level == one.leaf_level);
  }
}

TEST(TreeLayout, ChildrenCoverTheirParentInKeyOrderAndKnowIt) {
  std::mt19937 random(3);
  for (int i = 0; i < 5000; ++i) {
    const TreeLayout l = make_layout(1 << 20, 1 << 20, 16, 1 + i % 2);
    TileId id{static_cast<int>(random() % static_cast<unsigned>(l.leaf_level)), 0, 0};
    id.x = static_cast<std::uint32_t>(random()) % l.tiles_x(id.level);
    id.y = static_cast<std::uint32_t>(random()) % l.tiles_y(id.level);
    std::int64_t cells = 0;
    for (int q = 0; q < l.child_count(id.level); ++q) {
      const TileId child = l.child(id, q);
      EXPECT_EQ(l.parent(child), id);
      EXPECT_EQ(child.level, id.level + 1);
      EXPECT_EQ(child.key(), l.child(id, 0).key() + q);
      const CellRect outer = l.cells(id), inner = l.cells(child);
      EXPECT_TRUE(inner.column0 >= outer.column0 && inner.column1 <= outer.column1);
      EXPECT_TRUE(inner.row0 >= outer.row0 && inner.row1 <= outer.row1);
      if (!inner.empty()) cells += (inner.column1 - inner.column0) * (inner.row1 - inner.row0);
    }
    const CellRect outer = l.cells(id);
    EXPECT_EQ(cells, (outer.column1 - outer.column0) * (outer.row1 - outer.row0)) << id.text();
  }
}

TEST(TreeLayout, QuadrantsGoNorthWestNorthEastSouthWestSouthEast) {
  const TreeLayout l = make_layout(1000, 1000, 16);
  const TileId id{3, 5, 2};
  EXPECT_EQ(l.child(id, 0), (TileId{4, 10, 4}));
  EXPECT_EQ(l.child(id, 1), (TileId{4, 11, 4}));
  EXPECT_EQ(l.child(id, 2), (TileId{4, 10, 5}));
  EXPECT_EQ(l.child(id, 3), (TileId{4, 11, 5}));
}

TEST(TreeLayout, TilesOfALevelCoverEveryCellOnce) {
  for (const auto& [columns, rows] : {std::array{65, 65}, {66, 40}, {2, 97}, {130, 3}, {64, 63}}) {
    const TreeLayout l = make_layout(columns, rows, 8, columns == 66 ? 2 : 1);
    for (int level = 0; level <= l.leaf_level; ++level) {
      std::vector<int> hits(static_cast<std::size_t>((columns - 1) * (rows - 1)));
      const std::uint32_t side = std::uint32_t{1} << l.halvings(level);
      for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
          const CellRect c = l.cells({level, x, y});
          EXPECT_EQ(c.empty(), x >= l.tiles_x(level) || y >= l.tiles_y(level));
          for (auto row = c.row0; row < c.row1; ++row) {
            for (auto column = c.column0; column < c.column1; ++column) {
              ++hits[static_cast<std::size_t>(row * (columns - 1) + column)];
            }
          }
        }
      }
      for (const int h : hits) ASSERT_EQ(h, 1) << "level " << level << " of " << columns << " x " << rows;
    }
  }
}

TEST(GridFrame, WorldFollowsTheDefinition) {
  const TreeLayout l = make_layout(1000, 700, 16);
  TileMesh mesh;
  mesh.xy_shift = -2;
  mesh.z_offset = -1234;
  const GridFrame frame(l, {l.leaf_level, 3, 5}, mesh);
  EXPECT_EQ(frame.column(6), 48 + 1.5);
  EXPECT_EQ(frame.row(1), 80 + 0.25);
  EXPECT_EQ(frame.height_m(34), -1200 * 0.125);
  const auto p = frame.world({6, 1, 34});
  EXPECT_EQ(p[0], 49.5 * 30.5);
  EXPECT_EQ(p[1], -80.25 * 28.25);
  EXPECT_EQ(p[2], -150);
}

TEST(GridFrame, WorldFollowsTheAxes) {
  TreeLayout l = make_layout(1000, 700, 16);
  l.axes = {{0.6, 0.8}, {1, 0}};
  const GridFrame frame(l, {l.leaf_level, 3, 5}, {});
  const auto p = frame.world({1, 2, 0});
  EXPECT_DOUBLE_EQ(p[0], 49 * 30.5 * 0.6 + 82 * 28.25);
  EXPECT_DOUBLE_EQ(p[1], 49 * 30.5 * 0.8);
}

/// Axes at any angle to each other, rows clockwise of columns.
GridAxes random_axes(std::mt19937& random) {
  std::uniform_real_distribution<> turn(0, 6.3);
  std::uniform_real_distribution<> between(0.3, 2.8);
  const double a = turn(random);
  const double b = a - between(random);
  return {{std::cos(a), std::sin(a)}, {std::cos(b), std::sin(b)}};
}

TEST(TreeLayout, GridUndoesWorld) {
  std::mt19937 random(3);
  TreeLayout l = make_layout(1000, 700, 16);
  for (int i = 0; i < 1000; ++i) {
    const double column = static_cast<double>(random() % 100000) / 7;
    const double row = static_cast<double>(random() % 100000) / 7;
    const auto p = l.world(column, row);
    const auto back = l.grid(p[0], p[1]);
    EXPECT_NEAR(back[0], column, 1e-8);
    EXPECT_NEAR(back[1], row, 1e-8);
    l.axes = random_axes(random);
  }
}

TEST(GridFrame, MatrixDoesWhatWorldDoes) {
  std::mt19937 random(7);
  TreeLayout l = make_layout(100000, 70000, 128);
  for (int i = 0; i < 1000; ++i) {
    if (i % 2 == 1) l.axes = random_axes(random);
    const int level = static_cast<int>(random() % static_cast<unsigned>(l.leaf_level + 1));
    const TileId id{level, static_cast<std::uint32_t>(random()) % l.tiles_x(level),
                    static_cast<std::uint32_t>(random()) % l.tiles_y(level)};
    TileMesh mesh;
    mesh.xy_shift = static_cast<int>(random() % 8) - 3;
    mesh.z_offset = static_cast<std::int64_t>(random() % 100000) - 50000;
    const GridFrame frame(l, id, mesh);
    const GridVertex v{static_cast<std::int32_t>(random() % 1024), static_cast<std::int32_t>(random() % 1024),
                       static_cast<std::int32_t>(random() % 65536)};
    const std::array<double, 3> eye{1e5, -2e5, 3000};
    const auto m = frame.matrix(eye);
    const auto p = frame.world(v);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double q = m[axis] * v.x + m[4 + axis] * v.y + m[8 + axis] * v.z + m[12 + axis];
      EXPECT_NEAR(q, p[axis] - eye[axis], 1e-7);
    }
  }
}

TEST(GridFrame, NeighboursAgreeOnASharedVertexToTheLastBit) {
  std::mt19937 random(9);
  TreeLayout l = make_layout(4000, 4000, 64);
  for (int i = 0; i < 2000; ++i) {
    // Steps that are no dyadic fraction make every rounding show.
    const double step = std::uniform_real_distribution<>(1e-3, 1)(random);
    l.z_step_m.assign(l.z_step_m.size(), step);
    TileMesh west;
    TileMesh east;
    west.z_offset = static_cast<std::int64_t>(random() % 20000) - 10000;
    east.z_offset = west.z_offset + static_cast<std::int64_t>(random() % 2000) - 1000;
    east.xy_shift = -1;
    const auto x = static_cast<std::uint32_t>(random() % 20);
    const GridFrame a(l, {l.leaf_level, x, 4}, west);
    const GridFrame b(l, {l.leaf_level, x + 1, 4}, east);
    const auto z = static_cast<std::int32_t>(1000 + random() % 60000);
    const auto p = a.world({64, 7, z});
    const auto q = b.world({0, 14, static_cast<std::int32_t>(z + west.z_offset - east.z_offset)});
    EXPECT_EQ(p, q);
  }
}

}  // namespace
}  // namespace tintree::codec
