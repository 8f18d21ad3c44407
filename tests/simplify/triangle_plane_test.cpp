/// Which samples lie in a triangle, however large it is, against exact integers.

#include "simplify/triangle_plane.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>

namespace tintree::simplify {
namespace {

struct Corner {
  std::int64_t x;
  std::int64_t y;
};

/// Twice the area that a sample has against a side, not negative inside.
std::int64_t area(const Corner& p, const Corner& q, std::int64_t x, std::int64_t y) {
  return (p.y - q.y) * (x - p.x) + (q.x - p.x) * (y - p.y);
}

TEST(TrianglePlane, TellsSamplesInsideFromOutsideInAnySize) {
  std::mt19937 random(1);
  for (int bits = 4; bits <= 29; ++bits) {
    std::uniform_int_distribution<std::int64_t> place(0, std::int64_t{1} << bits);
    for (int round = 0; round < 40; ++round) {
      std::array<Corner, 3> t{};
      for (Corner& c : t) c = {place(random), place(random)};
      const std::int64_t doubled = area(t[2], t[0], t[1].x, t[1].y);
      if (doubled == 0) continue;
      if (doubled < 0) std::swap(t[1], t[2]);
      const auto point = [](const Corner& c) { return Point{static_cast<double>(c.x), static_cast<double>(c.y), 0}; };
      const TrianglePlane plane(point(t[0]), point(t[1]), point(t[2]));
      // Around a point of the first side, where it is close.
      const double share = static_cast<double>(round) / 40;
      const auto along = [share](std::int64_t from, std::int64_t to) {
        return from + static_cast<std::int64_t>(share * static_cast<double>(to - from)) - 16;
      };
      const std::int64_t x0 = along(t[2].x, t[0].x);
      const std::int64_t y0 = along(t[2].y, t[0].y);
      const RectTriangle rect = plane.over(x0, y0, 0);
      for (std::size_t k = 0; k < 3; ++k) {
        const Corner& p = t[(k + 2) % 3];
        const Corner& q = t[k];
        const std::int64_t length = std::abs(p.x - q.x) + std::abs(p.y - q.y);
        const std::int64_t margin = length <= 1 << 20 ? 0 : length >> 16;
        for (std::int32_t j = 0; j < kMaxRectSamples; ++j) {
          for (std::int32_t i = 0; i < kMaxRectSamples; ++i) {
            const std::int64_t value = std::int64_t{rect.sides[k].start} + std::int64_t{rect.sides[k].per_column} * i +
                                       std::int64_t{rect.sides[k].per_row} * j;
            ASSERT_LT(std::abs(value), std::int64_t{1} << 31) << "overflows";
            const std::int64_t exact = area(p, q, x0 + i, y0 + j);
            ASSERT_TRUE(exact < 0 || value >= 0) << "a sample is lost at " << bits << " bits";
            ASSERT_TRUE(exact >= -margin || value < 0) << "a sample outside at " << bits << " bits";
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace tintree::simplify
