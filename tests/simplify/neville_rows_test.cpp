#include "simplify/neville_rows.h"

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace tintree::simplify {
namespace {

using Heights = std::function<double(std::int64_t column, std::int64_t row)>;

SampleRows rows_of(const Heights& heights) {
  return [heights](std::int64_t column, std::int64_t row, std::vector<double>& out) {
    for (double& h : out) h = heights(column++, row);
  };
}

/// The filter as Kovacevic and Sweldens tabulate it, sample by sample, layer upon layer.
double by_definition(const Heights& heights, int layer, std::int64_t column, std::int64_t row) {
  if (layer == 0) return heights(column, row);
  double sum = 0;
  for (int j = -1; j <= 2; ++j) {
    for (int i = -1; i <= 2; ++i) {
      const bool outer_x = i == -1 || i == 2;
      const bool outer_y = j == -1 || j == 2;
      const double weight = outer_x && outer_y ? 0 : outer_x || outer_y ? -1.0 / 32 : 10.0 / 32;
      if (weight != 0) sum += weight * by_definition(heights, layer - 1, 2 * column + i, 2 * row + j);
    }
  }
  return sum;
}

TEST(NevilleRows, AreTheFilterByItsDefinition) {
  const Heights noise = [](std::int64_t column, std::int64_t row) {
    std::mt19937 random(static_cast<unsigned>(1000 * column + row));
    return std::uniform_real_distribution(0.0, 100.0)(random);
  };
  for (int layer = 0; layer <= 3; ++layer) {
    NevilleRows rows(rows_of(noise), layer, -3, 5, 7);
    for (std::int64_t row = 5; row < 10; ++row) {
      const std::vector<double>& out = rows.next();
      ASSERT_EQ(out.size(), 7U);
      for (std::size_t x = 0; x < out.size(); ++x) {
        EXPECT_NEAR(out[x], by_definition(noise, layer, static_cast<std::int64_t>(x) - 3, row), 1e-10);
      }
    }
  }
}

/// Order 4: a cubic has its own value in the middle of four samples.
TEST(NevilleRows, GiveEveryCubicExactly) {
  const auto cubic = [](double x, double y) {
    return 3 + x - 2 * y + x * y + 0.5 * x * x * y - 0.3 * y * y * y + 0.1 * x * x * x;
  };
  NevilleRows rows(
      rows_of([&](std::int64_t c, std::int64_t r) { return cubic(static_cast<double>(c), static_cast<double>(r)); }), 2,
      0, 0, 6);
  for (int y = 0; y < 6; ++y) {
    const std::vector<double>& out = rows.next();
    for (int x = 0; x < 6; ++x) EXPECT_NEAR(out[static_cast<std::size_t>(x)], cubic(4 * x + 1.5, 4 * y + 1.5), 1e-8);
  }
}

TEST(NevilleRows, TakeTheMeanOfWhatIsThereWhereSamplesAreMissing) {
  const double missing = std::numeric_limits<double>::quiet_NaN();
  const Heights holes = [&](std::int64_t c, std::int64_t r) {
    return r < 2 && c > 4 ? missing : static_cast<double>(c + 10 * r);
  };
  NevilleRows rows(rows_of(holes), 1, 1, 0, 3);
  const std::vector<double>& out = rows.next();
  EXPECT_DOUBLE_EQ(out[0], (2 + 3 + 12 + 13) / 4.0);
  EXPECT_DOUBLE_EQ(out[1], (4 + 14) / 2.0);
  EXPECT_TRUE(std::isnan(out[2]));
}

}  // namespace
}  // namespace tintree::simplify
