#include "simplify/scalar_levels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

/// Inside a tile of all samples, with height steps of 1 m.
ScalarSpec spec_of(const test::Terrain& terrain) {
  ScalarSpec spec;
  const auto last_column = static_cast<std::int32_t>(terrain.surface->blocks().columns() - 1);
  const auto last_row = static_cast<std::int32_t>(terrain.surface->blocks().rows() - 1);
  spec.level.heights.step_m = 1;
  spec.sides = {{{0, last_column}, {0, last_column}, {0, last_row}, {0, last_row}}};
  return spec;
}

HeightHistogram histogram_of(const test::Terrain& terrain) {
  SurfaceView view(*terrain.surface);
  return height_histogram(view, spec_of(terrain));
}

TEST(HeightHistogram, CountsWhatIsInside) {
  const auto height = [](int c, int r) {
    return c == 7 && r == 9 ? test::kMissing : std::round(40 * test::noise(c, r));
  };
  const test::Terrain terrain = test::make_terrain(70, 50, height);
  std::map<std::int64_t, double> expected;
  for (int r = 1; r < 49; ++r) {
    for (int c = 1; c < 69; ++c) {
      if (c != 7 || r != 9) ++expected[std::llround(height(c, r))];
    }
  }
  const HeightHistogram found = histogram_of(terrain);
  std::map<std::int64_t, double> counted;
  for (const codec::HeightWeight& h : found.heights) counted[found.lowest + std::llround(h.height_m)] = h.weight;
  EXPECT_EQ(counted, expected);
  EXPECT_TRUE(histogram_of(test::make_terrain(9, 9, [](int, int) { return test::kMissing; })).heights.empty());
}

/// Fewer levels than that cannot be within `most_off` of all heights.
std::size_t fewest_levels(const HeightHistogram& histogram, std::int64_t most_off) {
  std::size_t count = 0;
  double reached = -1;
  for (const codec::HeightWeight& h : histogram.heights) {
    if (h.height_m <= reached) continue;
    ++count;
    reached = h.height_m + 2 * static_cast<double>(most_off);
  }
  return count;
}

double farthest(const HeightHistogram& histogram, const std::vector<std::int64_t>& levels) {
  double most = 0;
  for (const codec::HeightWeight& h : histogram.heights) {
    double near = 1e300;
    for (const std::int64_t level : levels)
      near = std::min(near, std::abs(static_cast<double>(level - histogram.lowest) - h.height_m));
    most = std::max(most, near);
  }
  return most;
}

TEST(LloydMaxLevels, NoHeightIsFartherOffThanAllowed) {
  // Bell-shaped, with sparse tails on both sides.
  HeightHistogram bell{-500, {}};
  for (int z = 0; z < 1000; ++z) {
    const double weight = std::floor(1e4 * std::exp(-0.5 * std::pow((z - 500) / 90.0, 2)));
    if (weight > 0) bell.heights.push_back({static_cast<double>(z), weight});
  }
  for (const std::int64_t most_off : {0, 1, 3, 50}) {
    const std::vector<std::int64_t> levels = lloyd_max_levels(bell, most_off);
    EXPECT_TRUE(std::ranges::is_sorted(levels));
    EXPECT_LE(farthest(bell, levels), static_cast<double>(most_off));
    const std::size_t fewest = fewest_levels(bell, most_off);
    EXPECT_GE(levels.size(), fewest);
    EXPECT_LE(levels.size(), 2 * fewest);
  }
}

TEST(LloydMaxLevels, EndsOnFlatTwoValuedAndSpikedHeights) {
  EXPECT_TRUE(lloyd_max_levels({}, 3).empty());
  EXPECT_EQ(lloyd_max_levels({1234, {{0, 66049}}}, 3), std::vector<std::int64_t>{1234});
  EXPECT_EQ(lloyd_max_levels({-9, {{0, 5}, {4000000, 66000}}}, 3), (std::vector<std::int64_t>{-9, 3999991}));
  EXPECT_EQ(lloyd_max_levels({0, {{0, 40000}, {2, 20000}, {4000000, 1}}}, 3).size(), 2U);
}

}  // namespace
}  // namespace tintree::simplify
