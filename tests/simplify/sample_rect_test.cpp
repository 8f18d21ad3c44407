/// The loops over eight samples at a time against a plain one in double.

#include "simplify/sample_rect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cache/height_blocks.h"
#include "simplify/surface_distance.h"
#include "tests/simplify/brute_distance.h"

namespace tintree::simplify {
namespace {

using test::QuarterPoint;

constexpr int kSamples = cache::kBlockSamples;
constexpr double kBase = 1200;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
/// What clip_rect takes for "so near the opposite side that the hub cannot move it".
constexpr double kLightWeight = 1e-6;

/// A rectangle of samples and a triangle over it.
struct Case {
  std::int64_t column;
  std::int64_t row;
  int columns;
  int rows;
  std::array<QuarterPoint, 3> corners;

  TrianglePlane plane() const { return {corners[0].point(), corners[1].point(), corners[2].point()}; }
  RectTriangle over() const { return plane().over(column, row, kBase); }
};

class SampleRectTest : public testing::TestWithParam<double> {
 protected:
  SampleRectTest() : heights_(std::size_t{cache::kBlockStride} * kSamples, kNaN) {
    for (int j = 0; j < kSamples; ++j) {
      for (int i = 0; i < kSamples; ++i) {
        const bool missing = std::uniform_real_distribution<double>(0, 1)(random_) < GetParam();
        heights_[slot(i, j)] = missing ? kNaN : static_cast<float>(terrain_m(i, j) + pick_m(2));
      }
    }
  }

  static std::size_t slot(std::int64_t i, std::int64_t j) {
    return static_cast<std::size_t>(j * cache::kBlockStride + i);
  }
  /// Relative to kBase.
  static double terrain_m(double x, double y) { return 0.3 * x - 0.2 * y + 5 * std::sin(x / 9) * std::cos(y / 7); }

  std::int64_t pick(std::int64_t low, std::int64_t high) {
    return std::uniform_int_distribution<std::int64_t>(low, high)(random_);
  }
  double pick_m(double spread) { return std::uniform_real_distribution<double>(-spread, spread)(random_); }

  /// A triangle of at most `reach` samples, and the samples of the block under it or, where they are too many, some.
  Case random_case(std::int64_t reach, double spread_m) {
    Case c{};
    do {
      const std::int64_t mask = pick(0, 1) == 0 ? ~std::int64_t{3} : ~std::int64_t{0};
      const std::int64_t x = pick(0, 4 * (kSamples - 1)) - 2 * reach;
      const std::int64_t y = pick(0, 4 * (kSamples - 1)) - 2 * reach;
      for (QuarterPoint& p : c.corners) {
        p = {(x + pick(0, 4 * reach)) & mask, (y + pick(0, 4 * reach)) & mask, 0};
        p.z = kBase + terrain_m(static_cast<double>(p.x) / 4, static_cast<double>(p.y) / 4) + pick_m(spread_m);
      }
      const Extent extent = c.plane().extent;
      c.columns = cut(extent.x0, extent.x1, c.column);
      c.rows = cut(extent.y0, extent.y1, c.row);
    } while (doubled_area(c) == 0 || c.columns <= 0 || c.rows <= 0);
    return c;
  }

  /// Samples of the block from `from` to `to`, but no more than fit a rectangle; `first` is the first.
  int cut(double from, double to, std::int64_t& first) {
    const auto low = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(from)));
    const auto high = std::min<std::int64_t>(kSamples - 1, static_cast<std::int64_t>(std::floor(to)));
    const std::int64_t count = std::min<std::int64_t>(high - low + 1, kMaxRectSamples);
    first = count <= 0 ? low : pick(low, high + 1 - count);
    return static_cast<int>(count);
  }

  static std::int64_t doubled_area(const Case& c) {
    return test::cross(c.corners[0], c.corners[1], c.corners[2].x, c.corners[2].y);
  }

  SampleRect rect(const Case& c) const { return {&heights_[slot(c.column, c.row)], c.columns, c.rows}; }

  /// Calls visit(weight, residual) for every sample in the closed triangle; a NaN residual is a missing one's.
  template <typename Visit>
  void for_each_inside(const Case& c, const Visit& visit) const {
    const auto& [hub, b, d] = c.corners;
    const std::int64_t area = doubled_area(c);
    const auto share = [area](std::int64_t part) { return static_cast<double>(part) / static_cast<double>(area); };
    for (std::int64_t y = c.row; y < c.row + c.rows; ++y) {
      for (std::int64_t x = c.column; x < c.column + c.columns; ++x) {
        const double u = share(test::cross(b, d, 4 * x, 4 * y));
        const double v = share(test::cross(d, hub, 4 * x, 4 * y));
        const double w = share(test::cross(hub, b, 4 * x, 4 * y));
        if (u < 0 || v < 0 || w < 0) continue;
        visit(u, kBase + static_cast<double>(heights_[slot(x, y)]) - (u * hub.z + v * b.z + w * d.z));
      }
    }
  }

  /// What rounding may take: as of the largest height, relative to the base, and weight over the rectangle.
  double guard(const Case& c, double bound) const {
    const TrianglePlane plane = c.plane();
    double height = 0;
    double weight = 1;
    for (const int i : {0, c.columns - 1}) {
      for (const int j : {0, c.rows - 1}) {
        const auto x = static_cast<double>(c.column + i);
        const auto y = static_cast<double>(c.row + j);
        height = std::max(height, std::abs(plane.height(x, y) - kBase));
        weight = std::max(weight, std::abs(plane.weight(x, y)));
      }
    }
    for (const QuarterPoint& p : c.corners) height = std::max(height, std::abs(p.z - kBase));
    for (int j = 0; j < c.rows; ++j) {
      for (int i = 0; i < c.columns; ++i) {
        const double h = std::abs(static_cast<double>(heights_[slot(c.column + i, c.row + j)]));
        if (h > height) height = h;
      }
    }
    return guard_m(height, bound * weight);
  }

  /// `stuck` counts samples of next to no weight: with it, one of them beyond the bound empties the interval.
  HeightInterval brute_clip(const Case& c, double bound, bool stuck, HeightInterval interval) const {
    for_each_inside(c, [&](double weight, double residual) {
      if (weight > kLightWeight) test::narrow(weight, residual, bound, interval);
      if (weight <= 2 * kLightWeight && stuck && std::abs(residual) > bound) interval = {1, -1};
    });
    return interval;
  }

  void compare_clip(const Case& c, double bound, bool light) {
    const double rounding = guard(c, bound);
    const HeightInterval start = pick(0, 3) == 0   ? HeightInterval{0, 0}
                                 : pick(0, 1) == 0 ? HeightInterval{-bound, bound}
                                                   : HeightInterval{-bound, pick_m(bound)};
    auto lo = static_cast<float>(start.lo);
    auto hi = static_cast<float>(start.hi);
    const HeightInterval begun{static_cast<double>(lo), static_cast<double>(hi)};
    clip_rect(rect(c), c.over(), static_cast<float>(bound), light, lo, hi);
    const HeightInterval found{static_cast<double>(lo), static_cast<double>(hi)};
    const std::string what = "area " + std::to_string(static_cast<double>(doubled_area(c)) / 32) + " bound " +
                             std::to_string(bound) + " found " + std::to_string(lo) + ".." + std::to_string(hi);
    EXPECT_TRUE(test::holds(brute_clip(c, bound + rounding, false, begun), found)) << "too wide, " << what;
    EXPECT_TRUE(test::holds(found, brute_clip(c, bound - rounding, true, begun))) << "too narrow, " << what;
    ++(found.empty()                                                            ? emptied_
       : lo > static_cast<float>(start.lo) || hi < static_cast<float>(start.hi) ? narrowed_
                                                                                : kept_);
    ++(doubled_area(c) > 0 ? clockwise_ : counter_clockwise_);
  }

  void expect_all_outcomes(int least) const {
    for (const int count : {emptied_, narrowed_, kept_, clockwise_, counter_clockwise_}) EXPECT_GT(count, least);
  }

  std::mt19937 random_{5};
  std::vector<float> heights_;
  int emptied_ = 0;
  int narrowed_ = 0;
  int kept_ = 0;
  int clockwise_ = 0;
  int counter_clockwise_ = 0;
};

TEST_P(SampleRectTest, ClipMatchesBruteForce) {
  for (int round = 0; round < 6000; ++round) {
    const double bound = std::pow(2.0, std::uniform_real_distribution<double>(0, 5)(random_));
    compare_clip(random_case(std::int64_t{4} << pick(0, 4), bound / 2), bound, false);
  }
  expect_all_outcomes(150);
}

TEST_P(SampleRectTest, ClipUnderLargeTrianglesMatchesBruteForce) {
  for (int round = 0; round < 6000; ++round) {
    const double bound = std::pow(2.0, std::uniform_real_distribution<double>(2, 8)(random_));
    compare_clip(random_case(std::int64_t{64} << pick(0, 6), bound / 2), bound, true);
  }
  expect_all_outcomes(150);
}

TEST_P(SampleRectTest, WithinMatchesBruteForce) {
  int within = 0;
  int beyond = 0;
  for (int round = 0; round < 6000; ++round) {
    const double bound = std::pow(2.0, std::uniform_real_distribution<double>(0, 4)(random_));
    const Case c = random_case(std::int64_t{4} << pick(0, 5), 1);
    const double rounding = guard(c, bound);
    const auto brute = [&](double limit) {
      bool all = true;
      for_each_inside(c, [&](double, double residual) { all = all && std::abs(residual) <= limit; });
      return all;
    };
    const bool found = rect_within(rect(c), c.over(), static_cast<float>(bound));
    EXPECT_TRUE(!found || brute(bound + rounding)) << round;
    EXPECT_TRUE(found || !brute(bound - rounding)) << round;
    ++(found ? within : beyond);
  }
  EXPECT_GT(within, 500);
  EXPECT_GT(beyond, 500);
}

TEST_P(SampleRectTest, ClipUnderSliversMatchesBruteForce) {
  // Planes so steep that, over the corners of the rectangle, they lie far off all heights.
  int slivers = 0;
  for (int round = 0; round < 200000 && slivers < 2000; ++round) {
    const double bound = std::pow(2.0, std::uniform_real_distribution<double>(0, 5)(random_));
    const Case c = random_case(23, bound / 2);
    if (std::abs(doubled_area(c)) > 16 * 3 || std::min(c.columns, c.rows) < 8) continue;
    ++slivers;
    compare_clip(c, bound, false);
  }
  EXPECT_GT(slivers, 500);
}

INSTANTIATE_TEST_SUITE_P(Missing, SampleRectTest, testing::Values(0.0, 0.01, 0.3), [](const auto& missing) {
  return missing.index == 0 ? "None" : missing.index == 1 ? "Few" : "Many";
});

/// A row of samples at height 0 but for one.
class OneSampleTest : public testing::Test {
 protected:
  OneSampleTest() : heights_(std::size_t{cache::kBlockStride} * kSamples, 0.0F) {}
  float& at(int i, int j) { return heights_[static_cast<std::size_t>(j * cache::kBlockStride + i)]; }

  std::vector<float> heights_;
};

TEST_F(OneSampleTest, EveryPlaceOfARectangleCounts) {
  const TrianglePlane plane({-40, -40, 0}, {400, -40, 0}, {-40, 400, 0});
  for (const int columns : {1, 7, 8, 9, 17, 31}) {
    for (int i = 0; i < columns; ++i) {
      at(i, 2) = 100;
      const SampleRect samples{heights_.data(), columns, 3};
      float lo = -1;
      float hi = 1;
      clip_rect(samples, plane.over(0, 0, 0), 1, false, lo, hi);
      EXPECT_GT(lo, hi) << i << " of " << columns;
      EXPECT_FALSE(rect_within(samples, plane.over(0, 0, 0), 1)) << i << " of " << columns;
      at(i, 2) = 0;
    }
  }
}

TEST_F(OneSampleTest, NothingBeyondTheRectangleCounts) {
  const TrianglePlane plane({-40, -40, 0}, {400, -40, 0}, {-40, 400, 0});
  for (int i = 0; i < 48; ++i) at(i, 3) = 100;
  for (int j = 0; j < 5; ++j) at(19, j) = 100;
  const SampleRect samples{heights_.data(), 19, 3};
  float lo = -1;
  float hi = 1;
  clip_rect(samples, plane.over(0, 0, 0), 1, false, lo, hi);
  EXPECT_EQ(lo, -1);
  EXPECT_EQ(hi, 1);
  EXPECT_TRUE(rect_within(samples, plane.over(0, 0, 0), 1));
}

TEST_F(OneSampleTest, WithinSeesMissingSamplesAndSides) {
  const TrianglePlane plane({0, 0, 0}, {8, 0, 0}, {0, 8, 0});
  const SampleRect samples{heights_.data(), 9, 9};
  const auto found = [&](int i, int j, float h) {
    at(i, j) = h;
    const bool within = rect_within(samples, plane.over(0, 0, 0), 1);
    at(i, j) = 0;
    return within;
  };
  for (const float h : {2.0F, -2.0F, kNaN}) {
    EXPECT_FALSE(found(0, 0, h)) << "a corner";
    EXPECT_FALSE(found(4, 4, h)) << "the long side";
    EXPECT_FALSE(found(8, 0, h)) << "the end of the long side";
    EXPECT_TRUE(found(5, 4, h)) << "outside";
  }
}

/// A sample on the side opposite to the hub, where the hub moves nothing, off by twice the bound.
TEST(ClipRect, AllowsNothingBesideALightSampleBeyondTheBoundOfAnySize) {
  for (const float bound : {1e-20F, 1e-3F, 1.0F, 3e7F, 1e20F}) {
    SCOPED_TRACE(bound);
    std::vector<float> heights(static_cast<std::size_t>(cache::kBlockStride), 0.0F);
    RectTriangle triangle{};
    triangle.sides = {{{8, 0, 0}, {8, 0, 0}, {8, 0, 0}}};
    const SampleRect samples{heights.data(), 5, 1};
    float lo = -bound;
    float hi = bound;
    clip_rect(samples, triangle, bound, true, lo, hi);
    EXPECT_LE(lo, hi);
    heights[3] = 2 * bound;
    clip_rect(samples, triangle, bound, true, lo, hi);
    EXPECT_GT(lo, hi);
  }
}

}  // namespace
}  // namespace tintree::simplify
