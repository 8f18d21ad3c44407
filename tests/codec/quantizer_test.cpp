#include "codec/quantizer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tintree::codec {
namespace {

using Heights = std::vector<HeightWeight>;

/// `gap`: how much wider some of the distances between heights are.
Heights random_heights(std::mt19937& random, std::size_t count, double gap = 10) {
  Heights out;
  double height = -50;
  for (std::size_t i = 0; i < count; ++i) {
    height += 1 + static_cast<double>(random() % 20) * (random() % 5 == 0 ? gap : 1);
    out.push_back({height, 1 + static_cast<double>(random() % 9)});
  }
  return out;
}

double weight_of(const Heights& heights) {
  double sum = 0;
  for (const HeightWeight& h : heights) sum += h.weight;
  return sum;
}

/// Squared distances of heights [i, j) from their mean.
double cluster_cost(const Heights& heights, std::size_t i, std::size_t j) {
  double weight = 0;
  double sum = 0;
  for (std::size_t k = i; k < j; ++k) {
    weight += heights[k].weight;
    sum += heights[k].weight * heights[k].height_m;
  }
  double cost = 0;
  for (std::size_t k = i; k < j; ++k) cost += heights[k].weight * std::pow(heights[k].height_m - sum / weight, 2);
  return cost;
}

/// The least mean square error of any quantiser, by dynamic programming over where its intervals end.
double least_mean_square(const Heights& heights, std::size_t levels) {
  const std::size_t n = heights.size();
  std::vector<std::vector<double>> best(levels + 1,
                                        std::vector<double>(n + 1, std::numeric_limits<double>::infinity()));
  for (auto& row : best) row[0] = 0;
  for (std::size_t level = 1; level <= levels; ++level) {
    for (std::size_t j = 1; j <= n; ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        best[level][j] = std::min(best[level][j], best[level - 1][i] + cluster_cost(heights, i, j));
      }
    }
  }
  return best[levels][n] / weight_of(heights);
}

TEST(UniformQuantizer, IsThePapers) {
  const Quantizer q = uniform_quantizer(100, 180, 8);  // q = 10, c = 105
  ASSERT_EQ(q.values_m.size(), 8U);
  for (const double x : {100.0, 109.0, 111.0, 144.4, 179.9}) {
    const double index = std::floor((x - 100) / 10);
    EXPECT_EQ(q.index(x), static_cast<std::size_t>(index)) << x;
    EXPECT_DOUBLE_EQ(q.value(x), index * 10 + 105) << x;
  }
  EXPECT_EQ(q.index(180), 7U);
}

TEST(UniformQuantizer, ErrsByHalfAStepAtMost) {
  std::mt19937 random(3);
  for (const std::size_t levels : {1, 2, 3, 7, 64, 1000}) {
    const Heights heights = random_heights(random, 300);
    const double low = heights.front().height_m;
    const double high = heights.back().height_m;
    const Distortion found = distortion(uniform_quantizer(low, high, levels), heights);
    EXPECT_LE(found.max_m, (high - low) / static_cast<double>(levels) / 2 * (1 + 1e-12)) << levels;
  }
}

TEST(Quantizer, TakesTheNearestLevel) {
  std::mt19937 random(4);
  const Quantizer q = lloyd_max_quantizer(random_heights(random, 100), 13).quantizer;
  ASSERT_TRUE(std::ranges::is_sorted(q.values_m));
  for (double x = -80; x < 2000; x += 1.7) {
    const auto nearest = std::ranges::min(q.values_m, {}, [x](double v) { return std::abs(v - x); });
    EXPECT_EQ(std::abs(q.value(x) - x), std::abs(nearest - x)) << x;
  }
}

TEST(LloydMax, ComesNearTheOptimumAndNeverBelow) {
  std::mt19937 random(5);
  double ratios = 0;
  int cases = 0;
  for (int i = 0; i < 60; ++i) {
    // Between clusters far apart Lloyd's iteration does not move a level; terrain has none.
    const bool clustered = i % 2 == 0;
    const Heights heights = random_heights(random, 8 + random() % 40, clustered ? 10 : 1);
    const std::size_t levels = 2 + random() % 7;
    const LloydMaxDesign design = lloyd_max_quantizer(heights, levels);
    EXPECT_TRUE(design.converged);
    const double best = least_mean_square(heights, levels);
    const double found = distortion(design.quantizer, heights).mean_square;
    EXPECT_GE(found, best * (1 - 1e-9));
    if (best == 0 || clustered) continue;
    EXPECT_LE(found, 3 * best);
    ratios += found / best;
    ++cases;
  }
  EXPECT_LE(ratios / cases, 1.2);
}

TEST(LloydMax, EndsWhereBothOfLloydsConditionsHold) {
  std::mt19937 random(6);
  const Heights heights = random_heights(random, 400);
  const Quantizer q = lloyd_max_quantizer(heights, 17, 100000).quantizer;
  for (std::size_t i = 0; i < q.values_m.size(); ++i) {
    double sum = 0;
    double weight = 0;
    for (const HeightWeight& h : heights) {
      if (q.index(h.height_m) != i) continue;
      sum += h.weight * h.height_m;
      weight += h.weight;
    }
    ASSERT_GT(weight, 0) << "level " << i << " has no height";
    EXPECT_NEAR(q.values_m[i], sum / weight, 1e-3) << "level " << i << " is not its heights' mean";
  }
}

TEST(LloydMax, DistortionFallsWithLevelsAndRounds) {
  std::mt19937 random(7);
  const Heights heights = random_heights(random, 500);
  double last = std::numeric_limits<double>::infinity();
  for (int levels = 2; levels <= 512; levels *= 2) {
    const double now =
        distortion(lloyd_max_quantizer(heights, static_cast<std::size_t>(levels)).quantizer, heights).mean_square;
    EXPECT_LT(now, last) << levels;
    last = now;
  }
  EXPECT_EQ(last, 0) << "every height has its level";
  last = std::numeric_limits<double>::infinity();
  for (int rounds = 0; rounds < 30; ++rounds) {
    const double now = distortion(lloyd_max_quantizer(heights, 16, rounds).quantizer, heights).mean_square;
    EXPECT_LE(now, last) << rounds;
    last = now;
  }
}

TEST(LloydMax, BeatsTheUniformQuantizerOnAverage) {
  std::mt19937 random(8);
  for (const std::size_t levels : {4, 16, 64}) {
    const Heights heights = random_heights(random, 600);
    const auto uniform = uniform_quantizer(heights.front().height_m, heights.back().height_m, levels);
    EXPECT_LT(distortion(lloyd_max_quantizer(heights, levels).quantizer, heights).mean_square,
              distortion(uniform, heights).mean_square);
  }
}

TEST(LloydMax, StopsOnFlatTwoValuedAndSpikedHeights) {
  for (const std::size_t levels : {1, 2, 3, 16, 65536}) {
    const LloydMaxDesign flat = lloyd_max_quantizer(Heights{{12, 66049}}, levels);
    EXPECT_EQ(flat.quantizer.values_m, std::vector<double>{12});
    EXPECT_TRUE(flat.converged);
    const Heights two{{-5, 3}, {900, 66046}};
    const LloydMaxDesign split = lloyd_max_quantizer(two, levels);
    EXPECT_TRUE(split.converged);
    EXPECT_EQ(distortion(split.quantizer, two).mean_square == 0, levels >= 2);
  }
  // A plain of three heights and one spike: with four levels the spike has its own.
  const Heights spike{{0, 30000}, {1, 30000}, {2, 6000}, {1e6, 1}};
  const LloydMaxDesign three = lloyd_max_quantizer(spike, 3);
  EXPECT_TRUE(three.converged);
  EXPECT_LT(three.iterations, 500);
  EXPECT_DOUBLE_EQ(three.quantizer.value(1e6), 1e6);
  EXPECT_EQ(distortion(lloyd_max_quantizer(spike, 4).quantizer, spike).max_m, 0);
}

TEST(LloydMax, StopsWhereItIsToldTo) {
  std::mt19937 random(9);
  const Heights heights = random_heights(random, 3000);
  const LloydMaxDesign design = lloyd_max_quantizer(heights, 100, 2);
  EXPECT_EQ(design.iterations, 2);
  EXPECT_FALSE(design.converged);
}

TEST(Psnr, IsThePapers) {
  EXPECT_DOUBLE_EQ(psnr_db(1000, 1), 60);
  EXPECT_EQ(psnr_db(1000, 0), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace tintree::codec
