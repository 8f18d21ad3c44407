#include "apps/audit/error_histogram.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace tintree::audit {
namespace {

TEST(ErrorHistogram, QuantilesOfASortedList) {
  std::mt19937 random(5);
  std::exponential_distribution<> error(3);
  std::vector<double> errors(20000);
  for (double& e : errors) e = std::min(error(random), 2.0);
  ErrorHistogram histogram;
  histogram.add(errors, 2);
  std::ranges::sort(errors);
  for (const double part : {0.1, 0.5, 0.9, 0.999, 1.0}) {
    const double exact = errors[static_cast<std::size_t>(std::ceil(part * 20000)) - 1] / 2;
    EXPECT_GE(histogram.quantile(part), exact);
    EXPECT_LE(histogram.quantile(part), exact + 1.0 / ErrorHistogram::kBins + 1e-12);
  }
}

TEST(ErrorHistogram, CountsWhatLiesBeyondTheBoundAndLeavesOutNaN) {
  ErrorHistogram histogram;
  histogram.add(std::vector{0.0, 1.0, 1.5, std::numeric_limits<double>::quiet_NaN()}, 1);
  EXPECT_EQ(histogram.total(), 3U);
  EXPECT_EQ(histogram.beyond(), 1U) << "the bound itself is within";
  EXPECT_TRUE(std::isinf(histogram.quantile(1)));
  EXPECT_EQ(histogram.quantile(0.6), 1);
  const auto bars = histogram.bars(4);
  EXPECT_EQ(bars, (std::vector<std::uint64_t>{1, 0, 0, 1}));
  EXPECT_EQ(ErrorHistogram().quantile(0.5), 0);
}

TEST(ErrorHistogram, Adds) {
  ErrorHistogram a;
  ErrorHistogram b;
  a.add(std::vector{0.1, 0.2}, 1);
  b.add(std::vector{0.3}, 1);
  a.add(b);
  EXPECT_EQ(a.total(), 3U);
}

}  // namespace
}  // namespace tintree::audit
