#include "simplify/surface_window.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

using test::Terrain;

TEST(SurfaceWindow, HeightIsTheReferenceSurface) {
  const Terrain terrain = test::make_terrain(40, 30, test::rough_hills(20, 2, 0.1));
  SurfaceView view(*terrain.surface);
  const SurfaceWindow window(view, 3, 5);
  int missing = 0;
  // As far as a sample beyond the raster on all sides.
  for (int y = -4 * 6; y <= 4 * 25; ++y) {
    for (int x = -4 * 4; x <= 4 * 37; ++x) {
      const double found = window.height_at(x / 4.0, y / 4.0);
      const double expected = terrain.grid.surface(3 + x / 4.0, 5 + y / 4.0);
      EXPECT_EQ(std::isnan(found), std::isnan(expected)) << x << ' ' << y;
      missing += std::isnan(found) ? 1 : 0;
      if (std::isnan(found)) continue;
      EXPECT_NEAR(found, expected, 1e-12);
    }
  }
  EXPECT_GT(missing, 1000);
}

TEST(SurfaceWindow, RunsHoldTheSamplesOfTheirBlock) {
  for (const auto& [columns, rows, holes] : {std::tuple{513, 257, 0.0}, {600, 300, 0.0}, {300, 513, 0.01}}) {
    const Terrain terrain = test::make_terrain(columns, rows, test::rough_hills(300, 2, holes));
    SurfaceView view(*terrain.surface);
    const SurfaceWindow window(view, -7, 11);
    for (int k = 0; k < 300; ++k) {
      const auto column = k % 3 == 0 ? columns - 1 : static_cast<std::int64_t>(test::noise(k, 1) * columns);
      const auto row = k % 5 == 0 ? rows - 1 : static_cast<std::int64_t>(test::noise(k, 2) * rows);
      const SampleRun run = window.run_at(column + 7, row - 11);
      ASSERT_GE(run.columns, 1);
      ASSERT_GE(run.rows, 1);
      bool whole = true;
      for (std::int64_t j = 0; j < run.rows; ++j) {
        for (std::int64_t i = 0; i < run.columns; ++i) {
          const double expected = terrain.grid.at(column + i, row + j);
          const double found = run.base_m + static_cast<double>(run.heights[j * cache::kBlockStride + i]);
          whole = whole && !std::isnan(expected);
          ASSERT_TRUE(found == expected || (std::isnan(found) && std::isnan(expected))) << column + i << ' ' << row + j;
        }
      }
      EXPECT_TRUE(whole || !run.all_valid);
      // All that the block has, to its last sample: the raster's own last ones never begin a block.
      EXPECT_EQ((column + run.columns - 1) % 256, 0);
      EXPECT_EQ((row + run.rows - 1) % 256, 0);
    }
  }
}

TEST(SurfaceWindow, PatchesBoundTheSquareOfTheirCell) {
  const Terrain terrain = test::make_terrain(600, 300, test::rough_hills(300, 5, 0));
  SurfaceView view(*terrain.surface);
  constexpr std::int64_t kColumn0 = 37;
  constexpr std::int64_t kRow0 = -20;
  const SurfaceWindow window(view, kColumn0, kRow0);
  int bounded = 0;
  for (int k = 0; k < 600; ++k) {
    const int size = k % 3;
    const int cells = kPatchCells[static_cast<std::size_t>(size)];
    const auto column = static_cast<std::int64_t>(test::noise(k, 1) * 700) - 50;
    const auto row = static_cast<std::int64_t>(test::noise(k, 2) * 400) - 50;
    const PlanePatch* patch = window.patch_at(size, column - kColumn0, row - kRow0);
    ASSERT_EQ(patch != nullptr, column >= 0 && row >= 0 && column < 599 && row < 299) << column << ' ' << row;
    if (patch == nullptr) continue;
    const std::int64_t west = column / cells * cells;
    const std::int64_t north = row / cells * cells;
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (std::int64_t j = 0; j <= cells; ++j) {
      for (std::int64_t i = 0; i <= cells; ++i) {
        const double h = terrain.grid.at(west + i, north + j) - static_cast<double>(patch->c) -
                         static_cast<double>(patch->a) * static_cast<double>(i) -
                         static_cast<double>(patch->b) * static_cast<double>(j);
        low = std::min(low, h);
        high = std::max(high, h);
      }
    }
    EXPECT_NEAR(static_cast<double>(patch->high), high, 1e-3) << column << ' ' << row;
    if (west + cells > 599 || north + cells > 299) {
      EXPECT_TRUE(std::isnan(patch->low)) << "a square that the raster does not fill";
      continue;
    }
    EXPECT_NEAR(static_cast<double>(patch->low), low, 1e-3) << column << ' ' << row;
    ++bounded;
  }
  EXPECT_GT(bounded, 150);
}

TEST(SurfaceWindow, KnowsWhereTheRasterLies) {
  const Terrain terrain = test::make_terrain(60, 40, [](int, int) { return 1.0; });
  SurfaceView view(*terrain.surface);
  const Extent raster = SurfaceWindow(view, 8, -4).extent();
  EXPECT_TRUE(raster.holds({-8, 4, 51, 43})) << "all of it";
  EXPECT_TRUE(raster.holds({51, 43, 51, 43})) << "the last sample";
  EXPECT_FALSE(raster.holds({-8.25, 4, 51, 43}));
  EXPECT_FALSE(raster.holds({-8, 3.75, 51, 43}));
  EXPECT_FALSE(raster.holds({-8, 4, 51.25, 43}));
  EXPECT_FALSE(raster.holds({-8, 4, 51, 43.25}));
}

}  // namespace
}  // namespace tintree::simplify
