#include "simplify/height_interval.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace tintree::simplify {
namespace {

TEST(HeightInterval, ClipKeepsWhatEachPointAllows) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-10, 10);
  std::uniform_real_distribution<double> weight(0.01, 1);
  for (int round = 0; round < 2000; ++round) {
    HeightInterval interval{-8, 8};
    struct Point {
      double weight, residual, bound;
    };
    std::array<Point, 3> points{};
    for (Point& p : points) {
      p = {weight(random), place(random), 9};
      interval.clip(p.weight, p.residual, p.bound);
    }
    for (double z = -8; z <= 8; z += 0.125) {
      bool allowed = true;
      bool hard_by = false;
      for (const Point& p : points) {
        const double off = std::abs(p.weight * z - p.residual) - p.bound;
        allowed = allowed && off <= 0;
        hard_by = hard_by || std::abs(off) < 1e-9;
      }
      EXPECT_TRUE(hard_by || allowed == (z >= interval.lo && z <= interval.hi)) << z;
    }
  }
}

TEST(HeightInterval, MissingSamplesAllowEverything) {
  HeightInterval interval{-1, 2};
  interval.clip(0.5, std::numeric_limits<double>::quiet_NaN(), 1);
  EXPECT_EQ(interval.lo, -1);
  EXPECT_EQ(interval.hi, 2);
}

TEST(HeightInterval, OneHeightIsNotEmpty) {
  EXPECT_FALSE((HeightInterval{1, 1}.empty()));
  EXPECT_TRUE((HeightInterval{1, 0.5}.empty()));
}

}  // namespace
}  // namespace tintree::simplify
