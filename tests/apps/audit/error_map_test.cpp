#include "apps/audit/error_map.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tintree::audit {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(ErrorMap, KeepsTheLargestErrorUnderEveryPixel) {
  // 100 x 50 samples on 10 x 5 pixels: 10 x 10 samples a pixel.
  ErrorMap map({0, 0, 99, 49}, 10);
  ASSERT_EQ(map.width_px(), 10);
  ASSERT_EQ(map.height_px(), 5);
  std::vector<double> values(40 * 30);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::fmod(static_cast<double>(i) * 0.618, 1.0);
  values[0] = kNaN;
  map.add(20, 10, {4, 3, 40, 30, values}, {});
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 10; ++x) {
      double largest = kNaN;
      for (int j = 0; j < 30; ++j) {
        for (int i = 0; i < 40; ++i) {
          const double v = values[static_cast<std::size_t>(j * 40 + i)];
          if ((24 + i) / 10 == x && (13 + j) / 10 == y) largest = std::fmax(largest, v);
        }
      }
      if (std::isnan(largest)) {
        EXPECT_TRUE(std::isnan(map.at(x, y)));
      } else {
        EXPECT_FLOAT_EQ(map.at(x, y), static_cast<float>(largest));
      }
    }
  }
}

TEST(ErrorMap, ShowsAPeakBetweenSamples) {
  ErrorMap map({10, 10, 20, 20}, 100);
  EXPECT_EQ(map.width_px(), 11) << "no pixel is smaller than a sample";
  const std::vector<double> values(4, 0.5);
  map.add(10, 10, {0, 0, 2, 2, values}, {7.5, 1.5, 0.25});
  EXPECT_FLOAT_EQ(map.at(1, 0), 7.5F);
  EXPECT_FLOAT_EQ(map.at(0, 0), 0.5F);
}

}  // namespace
}  // namespace tintree::audit
