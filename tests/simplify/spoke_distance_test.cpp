/// Edges against the definition, crossing by crossing, above all where they run along grid lines and block borders.

#include "simplify/spoke_distance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "simplify/surface_distance.h"
#include "tests/simplify/brute_distance.h"
#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

using test::QuarterPoint;
using test::Terrain;

/// A raster's size, so that its last column and row fall on, before or behind a block's border, and its holes.
struct SpokeCase {
  int columns;
  int rows;
  double holes;
};

class SpokeDistanceTest : public testing::TestWithParam<SpokeCase> {
 protected:
  SpokeDistanceTest()
      : terrain_(
            test::make_terrain(GetParam().columns, GetParam().rows, test::rough_hills(40, 1.5, GetParam().holes, 3))),
        guard_m_(1 - tested_bound_m(*terrain_.surface, {0, 0, GetParam().columns - 1, GetParam().rows - 1}, 1)) {}

  std::int64_t pick(std::int64_t low, std::int64_t high) {
    return std::uniform_int_distribution<std::int64_t>(low, high)(random_);
  }
  double pick_m(double spread) { return std::uniform_real_distribution<double>(-spread, spread)(random_); }

  /// Puts the point into the raster and near the surface.
  QuarterPoint settle(std::int64_t x, std::int64_t y, double spread_m) {
    QuarterPoint v{std::clamp<std::int64_t>(x, -4 * column0_, 4 * (GetParam().columns - 1 - column0_)),
                   std::clamp<std::int64_t>(y, -4 * row0_, 4 * (GetParam().rows - 1 - row0_)), 0};
    const Point p = v.point();
    const double h = terrain_.grid.surface(static_cast<double>(column0_) + p.x, static_cast<double>(row0_) + p.y);
    v.z = (std::isnan(h) ? 0 : h) + pick_m(spread_m);
    return v;
  }

  /// A coordinate at, or hard by, a place where something begins or ends.
  std::int64_t critical(std::int64_t samples, std::int64_t origin) {
    const std::int64_t last = samples - 1;
    const std::int64_t places[] = {0, 1, 16, 64, 255, 256, 257, 272, 320, last - 1, last};
    const std::int64_t at = 4 * (places[static_cast<std::size_t>(pick(0, std::ssize(places) - 1))] - origin);
    return pick(0, 1) == 0 ? at : at + pick(-4, 4);
  }

  void compare(const QuarterPoint& hub, const QuarterPoint& end, double bound) {
    SurfaceWindow window(view_, column0_, row0_);
    const HeightInterval start = pick(0, 3) == 0 ? HeightInterval{0, 0} : HeightInterval{-bound, bound};
    HeightInterval found = start;
    clip_spoke(window, hub.point(), end.point(), bound, found);
    const test::BruteSurface surface{terrain_.grid, column0_, row0_};
    const auto where = [&] {
      return std::to_string(hub.x) + "," + std::to_string(hub.y) + " to " + std::to_string(end.x) + "," +
             std::to_string(end.y) + " quarters";
    };
    EXPECT_TRUE(test::holds(test::brute_spoke(surface, hub, end, bound + guard_m_, start), found))
        << "too wide " << where();
    EXPECT_TRUE(test::holds(found, test::brute_spoke(surface, hub, end, bound - guard_m_, start)))
        << "too narrow " << where();
    ++(found.empty() ? emptied_ : found.lo > start.lo || found.hi < start.hi ? narrowed_ : kept_);
  }

  /// Some of each outcome, so that the comparison was one.
  void expect_all_outcomes(int least) {
    EXPECT_GT(emptied_, least);
    EXPECT_GT(narrowed_, least);
    EXPECT_GT(kept_, least);
    EXPECT_FALSE(view_.error().has_value());
  }

  double random_bound() { return std::pow(2.0, std::uniform_real_distribution<double>(-1, 6.5)(random_)); }

  Terrain terrain_;
  double guard_m_;
  SurfaceView view_{*terrain_.surface};
  std::mt19937 random_{17};
  std::int64_t column0_ = 0;
  std::int64_t row0_ = 0;
  int emptied_ = 0;
  int narrowed_ = 0;
  int kept_ = 0;
};

TEST_P(SpokeDistanceTest, RandomSpokesMatchBruteForce) {
  for (int round = 0; round < 3000; ++round) {
    column0_ = round % 2 == 0 ? 0 : pick(0, 200);
    row0_ = round % 2 == 0 ? 0 : pick(0, 200);
    const double bound = random_bound();
    const std::int64_t reach = std::int64_t{4} << pick(0, 10);
    const std::int64_t mask = pick(0, 1) == 0 ? ~std::int64_t{3} : ~std::int64_t{0};
    const QuarterPoint hub =
        settle(pick(0, 4 * GetParam().columns) & mask, pick(0, 4 * GetParam().rows) & mask, bound / 2);
    const QuarterPoint end =
        settle((hub.x + pick(-reach, reach)) & mask, (hub.y + pick(-reach, reach)) & mask, bound / 2);
    if (hub.x == end.x && hub.y == end.y) continue;
    compare(hub, end, bound);
  }
  expect_all_outcomes(150);
}

TEST_P(SpokeDistanceTest, SpokesAlongGridLinesMatchBruteForce) {
  constexpr int kDirections[8][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}, {-1, 0}, {0, -1}, {-1, -1}, {-1, 1}};
  for (int round = 0; round < 4000; ++round) {
    const double bound = random_bound();
    const QuarterPoint hub = settle(critical(GetParam().columns, 0), critical(GetParam().rows, 0), bound / 2);
    const auto& [dx, dy] = kDirections[round % 8];
    // As far as the raster goes, so that the direction is kept.
    const auto room = [](int step, std::int64_t from, std::int64_t samples) {
      return step == 0 ? 4 * 2000 : step > 0 ? 4 * (samples - 1) - from : from;
    };
    const std::int64_t most = std::min(room(dx, hub.x, GetParam().columns), room(dy, hub.y, GetParam().rows));
    const std::int64_t length = std::min(most, std::int64_t{1} << pick(2, 11));
    if (length == 0) continue;
    compare(hub, settle(hub.x + dx * length, hub.y + dy * length, bound / 2), bound);
  }
  expect_all_outcomes(150);
}

TEST_P(SpokeDistanceTest, SpokesAtBlockBordersMatchBruteForce) {
  for (int round = 0; round < 4000; ++round) {
    column0_ = round % 3 == 0 ? 0 : pick(-20, 100);
    row0_ = round % 3 == 0 ? 0 : pick(-20, 100);
    const double bound = random_bound();
    const QuarterPoint hub =
        settle(critical(GetParam().columns, column0_), critical(GetParam().rows, row0_), bound / 2);
    const QuarterPoint end =
        round % 2 == 0 ? settle(critical(GetParam().columns, column0_), critical(GetParam().rows, row0_), bound / 2)
                       : settle(hub.x + pick(-60, 60), hub.y + pick(-60, 60), bound / 2);
    if (hub.x == end.x && hub.y == end.y) continue;
    compare(hub, end, bound);
  }
  expect_all_outcomes(100);
}

INSTANTIATE_TEST_SUITE_P(Rasters, SpokeDistanceTest,
                         testing::Values(SpokeCase{513, 513, 0}, SpokeCase{600, 300, 0}, SpokeCase{514, 512, 0},
                                         SpokeCase{513, 513, 0.0005}, SpokeCase{600, 300, 0.2}),
                         [](const auto& raster) {
                           const SpokeCase& c = raster.param;
                           return "Of" + std::to_string(c.columns) + "By" + std::to_string(c.rows) +
                                  (c.holes == 0     ? "Whole"
                                   : c.holes < 0.01 ? "FewHoles"
                                                    : "ManyHoles");
                         });

TEST(SpokeDistance, SeesThePeakBetweenTwoFlatEnds) {
  // Only the crossing with the diagonal from (20, 20) to (21, 21) rises.
  const Terrain terrain = test::make_terrain(257, 257, [](int c, int r) { return c == 21 && r == 21 ? 10.0 : 0.0; });
  SurfaceView view(*terrain.surface);
  const SurfaceWindow window(view, 0, 0);
  HeightInterval interval{-3, 3};
  clip_spoke(window, {20, 21, 0}, {21, 20, 0}, 4, interval);
  EXPECT_EQ(interval.lo, 2) << "half of the peak at half the weight, less the bound";
  EXPECT_EQ(interval.hi, 3);
  interval = {-1, 1};
  clip_spoke(window, {20, 21, 0}, {21, 20, 0}, 4, interval);
  EXPECT_TRUE(interval.empty());
}

TEST(SpokeDistance, LeavesMissingSamplesAlone) {
  const Terrain terrain =
      test::make_terrain(257, 257, [](int c, int r) { return c == 40 && r == 40 ? test::kMissing : 0.0; });
  SurfaceView view(*terrain.surface);
  const SurfaceWindow window(view, 0, 0);
  HeightInterval interval{-3, 3};
  clip_spoke(window, {10, 40, 0}, {90, 40, 0}, 4, interval);
  EXPECT_EQ(interval.lo, -3);
  EXPECT_EQ(interval.hi, 3);
}

}  // namespace
}  // namespace tintree::simplify
