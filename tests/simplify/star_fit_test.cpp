/// The heights that a star allows its hub, against the overlay of the whole star.

#include "simplify/star_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

using test::Terrain;

constexpr std::int32_t kCells = 32;

/// A hub in a square of samples whose corners and side middles surround it, on a lattice far from height 0 or not.
class StarFitTest : public testing::TestWithParam<double> {
 protected:
  StarFitTest()
      : terrain_(test::make_exact_terrain(
            kCells + 1, kCells + 1,
            [up = GetParam()](int c, int r) { return up + test::hills(c, r, 10) + test::noise(c, r); })),
        view_(*terrain_.surface),
        distance_(view_, 0, 0) {
    spec_.heights = {0.25, static_cast<std::int64_t>(4 * GetParam())};
    spec_.sub_bits = 1;
    const std::int32_t n = kCells * 2;
    std::vector<LatticeVertex> vertices{{n / 2 + 3, n / 2 - 4, 0},
                                        {0, 0, 0},
                                        {0, n / 2, 0},
                                        {0, n, 0},
                                        {n / 2, n, 0},
                                        {n, n, 0},
                                        {n, n / 2, 0},
                                        {n, 0, 0},
                                        {n / 2, 0, 0}};
    std::vector<std::array<std::int32_t, 3>> triangles;
    for (std::int32_t k = 1; k <= 8; ++k) {
      const std::int32_t next = k == 8 ? 1 : k + 1;
      ring_.sides.push_back({k, next});
      ring_.spokes.push_back(k);
      triangles.push_back({0, k, next});
    }
    for (LatticeVertex& v : vertices) {
      if (&v != vertices.data()) v.z = spec_.heights.snap(terrain_.grid.at(v.x / 2, v.y / 2));
    }
    mesh_.build(std::move(vertices), triangles);
  }

  /// The star's error with its hub so high.
  double error_m(std::int32_t z) const {
    codec::TreeLayout layout;
    layout.columns = layout.rows = kCells + 1;
    layout.tile_cells = kCells;
    layout.z_step_m = {spec_.heights.step_m};
    codec::TileMesh tile;
    tile.xy_shift = -spec_.sub_bits;
    tile.z_offset = spec_.heights.origin;
    for (const LatticeVertex& v : mesh_.vertices) tile.vertices.push_back({v.x, v.y, v.z});
    tile.vertices[0].z = z;
    for (const Ring::Side& s : ring_.sides) {
      tile.triangles.push_back({0, static_cast<std::uint32_t>(s.from), static_cast<std::uint32_t>(s.to)});
    }
    return test::overlay(terrain_.grid, layout, {}, tile).max_m;
  }

  Terrain terrain_;
  SurfaceView view_;
  SurfaceDistance distance_;
  CollapseSpec spec_;
  HalfEdgeMesh mesh_;
  Ring ring_;
};

TEST_P(StarFitTest, AllowsJustTheHeightsThatKeepTheBound) {
  double least = 1e9;
  for (std::int32_t z = -120; z <= 120; ++z) least = std::min(least, error_m(z));
  const double bound = 1.3 * least;
  spec_.bound_m = tested_bound_m(*terrain_.surface, {0, 0, kCells, kCells}, bound);
  StarFit fit(mesh_, distance_, spec_);
  const HeightRange range = fit.heights(mesh_.vertex(0), ring_);
  ASSERT_FALSE(range.empty());
  EXPECT_GT(range.highest, range.lowest);
  const double guard = bound - spec_.bound_m;
  for (std::int32_t z = -120; z <= 120; ++z) {
    SCOPED_TRACE(z);
    const bool allowed = z >= range.lowest && z <= range.highest;
    const double error = error_m(z);
    EXPECT_TRUE(!allowed || error <= bound) << error;
    EXPECT_TRUE(allowed || error > spec_.bound_m - guard - 1e-4 * bound) << error;
    LatticeVertex hub = mesh_.vertex(0);
    hub.z = z;
    EXPECT_EQ(fit.keeps(hub, ring_), allowed);
  }
  EXPECT_TRUE(fit.heights(mesh_.vertex(0), ring_, 0.7).empty()) << "less than the least error";
}

TEST_P(StarFitTest, KnowsWhatCannotBeSpared) {
  double least = 1e9;
  for (std::int32_t z = -120; z <= 120; ++z) least = std::min(least, error_m(z));
  spec_.bound_m = tested_bound_m(*terrain_.surface, {0, 0, kCells, kCells}, 2 * least);
  StarFit fit(mesh_, distance_, spec_);
  int left = 0;
  for (double share = 1; share > 0.25; share -= 1.0 / 32) {
    SCOPED_TRACE(share);
    const HeightRange range = fit.heights(mesh_.vertex(0), ring_, share);
    if (range.empty()) continue;
    ++left;
    EXPECT_GE(range.spare, 0);
    // The least error there is takes part of the bound that is known without any fit.
    EXPECT_LE(share - range.spare, least / spec_.bound_m + 1e-4);
    EXPECT_TRUE(fit.heights(mesh_.vertex(0), ring_, share - range.spare - 1e-4).empty());
  }
  EXPECT_GT(left, 8);
}

TEST_P(StarFitTest, KnowsAFoldedStar) {
  StarFit fit(mesh_, distance_, spec_);
  const std::int32_t n = kCells * 2;
  EXPECT_TRUE(fit.unfolded({1, 1, 0}, ring_));
  EXPECT_FALSE(fit.unfolded({0, 1, 0}, ring_)) << "on an outer edge";
  EXPECT_FALSE(fit.unfolded({n + 1, 5, 0}, ring_));
}

INSTANTIATE_TEST_SUITE_P(Heights, StarFitTest, testing::Values(0.0, 1e6, -1e6));

}  // namespace
}  // namespace tintree::simplify
