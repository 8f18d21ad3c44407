#include "simplify/block_patches.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

using test::Terrain;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Compares one patch with every sample of its square, and with the surface between them.
void expect_patch_bounds(const Terrain& terrain, const PlanePatch& patch, std::int64_t column0, std::int64_t row0,
                         int cells) {
  double low = kInfinity;
  double high = -kInfinity;
  bool missing = false;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const double h = terrain.grid.at(column0 + i, row0 + j);
      missing = missing || std::isnan(h);
      if (std::isnan(h)) continue;
      const double residual =
          h - (static_cast<double>(patch.c) + static_cast<double>(patch.a) * i + static_cast<double>(patch.b) * j);
      low = std::min(low, residual);
      high = std::max(high, residual);
    }
  }
  EXPECT_EQ(patch.empty(), low > high);
  if (patch.empty()) return;
  EXPECT_EQ(std::isnan(patch.low), missing);
  EXPECT_GE(static_cast<double>(patch.high), high - 1e-9);
  EXPECT_LE(static_cast<double>(patch.high), high + 1e-3);
  if (missing) return;
  EXPECT_LE(static_cast<double>(patch.low), low + 1e-9);
  EXPECT_GE(static_cast<double>(patch.low), low - 1e-3);
  for (int k = 0; k < 200; ++k) {
    const double x = std::floor(test::noise(k, cells, 1) * cells * 8) / 8;
    const double y = std::floor(test::noise(k, cells, 2) * cells * 8) / 8;
    const double residual =
        terrain.grid.surface(static_cast<double>(column0) + x, static_cast<double>(row0) + y) -
        (static_cast<double>(patch.c) + static_cast<double>(patch.a) * x + static_cast<double>(patch.b) * y);
    EXPECT_GE(residual, static_cast<double>(patch.low) - 1e-9);
    EXPECT_LE(residual, static_cast<double>(patch.high) + 1e-9);
  }
}

void expect_pyramid_bounds(const Terrain& terrain) {
  const cache::HeightBlocks& blocks = terrain.surface->blocks();
  for (std::int64_t by = 0; by < blocks.blocks_y(); ++by) {
    for (std::int64_t bx = 0; bx < blocks.blocks_x(); ++bx) {
      const BlockPatches& patches = terrain.surface->patches(bx, by);
      for (std::size_t size = 0; size < kPatchCells.size(); ++size) {
        const int cells = kPatchCells[size];
        for (int j = 0; j < cache::kBlockCells; j += cells) {
          for (int i = 0; i < cache::kBlockCells; i += cells) {
            expect_patch_bounds(terrain, patches.at(static_cast<int>(size), i, j), bx * 256 + i, by * 256 + j, cells);
          }
        }
      }
    }
  }
}

TEST(PlanePatch, BoundsSmoothAndRoughSurfaces) {
  expect_pyramid_bounds(test::make_terrain(513, 257, test::rough_hills(300, 5, 0)));
  expect_pyramid_bounds(test::make_terrain(300, 280, [](int c, int r) { return 8000 + 100 * test::noise(c, r); }));
}

TEST(PlanePatch, KnowsMissingSamples) {
  expect_pyramid_bounds(test::make_terrain(300, 280, test::rough_hills(30, 5, 0.0005)));
  expect_pyramid_bounds(
      test::make_terrain(300, 280, [](int c, int r) { return c < 64 || r > 200 ? test::kMissing : c + r; }));
}

TEST(PlanePatch, IsThinOnAPlane) {
  const Terrain terrain = test::make_terrain(257, 257, [](int c, int r) { return 0.5 * c - 2 * r; });
  const PlanePatch& whole = terrain.surface->patches(0, 0).whole;
  EXPECT_LT(static_cast<double>(whole.high) - static_cast<double>(whole.low), 1e-3);
}

}  // namespace
}  // namespace tintree::simplify
