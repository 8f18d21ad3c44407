/// The squares listed row by row against each square of the box tested by itself.

#include "simplify/square_rows.h"

#include <cmath>
#include <cstdint>
#include <random>

#include <gtest/gtest.h>

namespace tintree::simplify {
namespace {

constexpr int kCells = 16;
constexpr int kReach = 200;

TEST(SquareRows, ListsWhatNoSideLeavesOut) {
  std::mt19937 random(7);
  // Quarters of samples; often the same row or column twice, for sides along the grid.
  std::uniform_int_distribution<int> coarse(-kReach / 16, kReach / 16);
  std::uniform_int_distribution<int> quarter(-kReach * 4, kReach * 4);
  std::bernoulli_distribution on_line(0.5);
  const auto coordinate = [&] { return on_line(random) ? coarse(random) * 16.0 : quarter(random) / 4.0; };
  int listed = 0;
  for (int round = 0; round < 2000; ++round) {
    const Point hub{coordinate(), coordinate(), 0};
    const Point b{on_line(random) ? hub.x : coordinate(), coordinate(), 0};
    const Point c{coordinate(), on_line(random) ? hub.y : coordinate(), 0};
    if ((b.x - hub.x) * (c.y - hub.y) == (c.x - hub.x) * (b.y - hub.y)) continue;
    const TrianglePlane plane(hub, b, c);
    const Extent extent = plane.extent;
    const double x0 = std::floor(extent.x0 / kCells) * kCells;
    const double y0 = std::floor(extent.y0 / kCells) * kCells;
    const SquareRows rows(plane, {x0, y0, x0 + kCells, y0 + kCells}, extent);
    for (double y = y0; y < extent.y1; y += kCells) {
      const SquareRows::Columns columns = rows.at(static_cast<std::int64_t>(y - y0));
      std::int64_t column = 0;
      for (double x = x0; x < extent.x1; x += kCells, ++column) {
        const bool misses = plane.misses({x, y, x + kCells, y + kCells});
        const bool in_row = column >= columns.first && column < columns.end;
        ASSERT_EQ(in_row, !misses) << "round " << round << ", square at " << x << ", " << y;
        listed += in_row ? 1 : 0;
      }
      ASSERT_LE(columns.end, column);
    }
  }
  EXPECT_GT(listed, 1000);
}

}  // namespace
}  // namespace tintree::simplify
