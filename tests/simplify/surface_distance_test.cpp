/// The fast interval checks against the definitions, sample by sample and crossing by crossing.

#include "simplify/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

using test::HeightGrid;
using test::Terrain;

/// A vertex in quarters of a sample, so that every test of position is exact in integers.
struct Vertex {
  std::int64_t x;
  std::int64_t y;
  double z;

  Point point() const { return {static_cast<double>(x) / 4, static_cast<double>(y) / 4, z}; }
};

std::int64_t cross(const Vertex& a, const Vertex& b, std::int64_t x, std::int64_t y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

/// Narrows the interval to the hub heights that bring a point of the given hub weight within the bound.
void narrow(double weight, double residual, double bound, HeightInterval& interval) {
  if (std::isnan(residual)) return;
  interval.lo = std::max(interval.lo, (residual - bound) / weight);
  interval.hi = std::min(interval.hi, (residual + bound) / weight);
}

/// Samples of the closed triangle but for those on its side (b, c). Relative to (column0, row0).
HeightInterval brute_triangle(const HeightGrid& grid, std::int64_t column0, std::int64_t row0,
                              const std::array<Vertex, 3>& t, double bound, HeightInterval interval) {
  const auto& [hub, b, c] = t;
  const std::int64_t area = cross(hub, b, c.x, c.y);
  for (std::int64_t y = 0; y < grid.rows - row0; ++y) {
    for (std::int64_t x = 0; x < grid.columns - column0; ++x) {
      const std::int64_t u = cross(b, c, 4 * x, 4 * y);
      const std::int64_t v = cross(c, hub, 4 * x, 4 * y);
      const std::int64_t w = cross(hub, b, 4 * x, 4 * y);
      const bool inside = area > 0 ? u > 0 && v >= 0 && w >= 0 : u < 0 && v <= 0 && w <= 0;
      if (!inside) continue;
      const auto share = [area](std::int64_t part) { return static_cast<double>(part) / static_cast<double>(area); };
      const double plane = share(u) * hub.z + share(v) * b.z + share(w) * c.z;
      narrow(share(u), grid.at(column0 + x, row0 + y) - plane, bound, interval);
    }
  }
  return interval;
}

/// The surface on the grid line through (x, y) in direction (dx, dy), `part` of `whole` of the way on.
double on_line(const HeightGrid& grid, std::int64_t x, std::int64_t y, int dx, int dy, std::int64_t part,
               std::int64_t whole) {
  if (part == 0) return grid.at(x, y);
  const double f = static_cast<double>(part) / static_cast<double>(whole);
  return (1 - f) * grid.at(x, y) + f * grid.at(x + dx, y + dy);
}

std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0); }

/// Every crossing of the spoke's inside with rows, columns and diagonals.
HeightInterval brute_spoke(const HeightGrid& grid, std::int64_t column0, std::int64_t row0, const Vertex& hub,
                           const Vertex& b, double bound, HeightInterval interval) {
  // Family k counts x, y or x - y; the coordinate that tells where on the line is y, x or x.
  for (int family = 0; family < 3; ++family) {
    const auto level = [family](const Vertex& v) { return family == 0 ? v.x : family == 1 ? v.y : v.x - v.y; };
    const auto place = [family](const Vertex& v) { return family == 0 ? v.y : v.x; };
    const std::int64_t span = level(b) - level(hub);
    if (span == 0) continue;
    const std::int64_t low = std::min(level(hub), level(b));
    const std::int64_t high = std::max(level(hub), level(b));
    for (std::int64_t k = floor_div(low, 4); 4 * k <= high; ++k) {
      if (4 * k <= low || 4 * k >= high) continue;
      // Share t = step / span of the way; the place is a fraction over 4 |span|.
      const std::int64_t step = 4 * k - level(hub);
      const std::int64_t sign = span < 0 ? -1 : 1;
      const std::int64_t whole = 4 * span * sign;
      const std::int64_t at = sign * (place(hub) * span + step * (place(b) - place(hub)));
      const std::int64_t cell = floor_div(at, whole);
      const std::int64_t part = at - cell * whole;
      const std::int64_t x = column0 + (family == 0 ? k : cell);
      const std::int64_t y = row0 + (family == 0 ? cell : family == 1 ? k : cell - k);
      const double surface = on_line(grid, x, y, family == 0 ? 0 : 1, family == 1 ? 0 : 1, part, whole);
      const double t = static_cast<double>(step) / static_cast<double>(span);
      narrow(1 - t, surface - (hub.z + t * (b.z - hub.z)), bound, interval);
    }
  }
  return interval;
}

/// `inner` allows no hub height that `outer` forbids, but for the rounding of its ends to float.
bool holds(const HeightInterval& outer, const HeightInterval& inner) {
  const double rounding = 1e-9 + 1e-7 * (std::abs(inner.lo) + std::abs(inner.hi));
  return inner.empty() || (inner.lo >= outer.lo - rounding && inner.hi <= outer.hi + rounding);
}

class SurfaceDistanceTest : public testing::TestWithParam<double> {
 protected:
  SurfaceDistanceTest() : terrain_(test::make_terrain(600, 300, test::rough_hills(40, 1.5, GetParam(), 3))) {}

  /// A vertex near the surface, in the raster's part south-east of (column0_, row0_).
  Vertex random_vertex(double spread_m) {
    const auto pick = [this](std::int64_t samples) {
      return std::uniform_int_distribution<std::int64_t>(0, 4 * (samples - 1))(random_);
    };
    Vertex v{pick(600 - column0_), pick(300 - row0_), 0};
    if (random_() % 2 == 0) v.x &= ~std::int64_t{3};
    if (random_() % 2 == 0) v.y &= ~std::int64_t{3};
    return settle(v, spread_m);
  }

  /// A vertex at most `reach` quarter samples off `v`.
  Vertex near(const Vertex& v, std::int64_t reach, double spread_m) {
    const auto shift = [&](std::int64_t from, std::int64_t samples) {
      const std::int64_t to = from + std::uniform_int_distribution<std::int64_t>(-reach, reach)(random_);
      return std::clamp<std::int64_t>(to, 0, 4 * (samples - 1));
    };
    return settle({shift(v.x, 600 - column0_), shift(v.y, 300 - row0_), 0}, spread_m);
  }

  Vertex settle(Vertex v, double spread_m) {
    const Point p = v.point();
    const double h = terrain_.grid.surface(static_cast<double>(column0_) + p.x, static_cast<double>(row0_) + p.y);
    v.z = (std::isnan(h) ? 0 : h) + std::uniform_real_distribution<double>(-spread_m, spread_m)(random_);
    return v;
  }

  /// Triangles and bounds such that some checks pass, some fail and some narrow the interval.
  void compare(std::int64_t reach, int rounds) {
    SurfaceView view(*terrain_.surface);
    SurfaceDistance distance(view, column0_, row0_);
    int narrowed = 0;
    for (int round = 0; round < rounds; ++round) {
      const double bound = std::pow(2.0, std::uniform_real_distribution<double>(0, 7)(random_));
      const double guard = 2 * (bound - tested_bound_m(*terrain_.surface, {0, 0, 599, 299}, bound));
      const Vertex hub = random_vertex(bound / 2);
      const std::array<Vertex, 3> t{hub, near(hub, reach, bound / 2), near(hub, reach, bound / 2)};
      const HeightInterval start = round % 4 == 0 ? HeightInterval{0, 0} : HeightInterval{-bound, bound};
      HeightInterval spoke = start;
      distance.clip_spoke(hub.point(), t[1].point(), bound - guard, spoke);
      EXPECT_TRUE(holds(brute_spoke(terrain_.grid, column0_, row0_, hub, t[1], bound, start), spoke)) << "too wide";
      EXPECT_TRUE(holds(spoke, brute_spoke(terrain_.grid, column0_, row0_, hub, t[1], bound - 2 * guard, start)))
          << "too narrow";
      if (cross(t[0], t[1], t[2].x, t[2].y) == 0) continue;
      HeightInterval clipped = start;
      distance.clip_triangle(hub.point(), t[1].point(), t[2].point(), bound - guard, clipped);
      EXPECT_TRUE(holds(brute_triangle(terrain_.grid, column0_, row0_, t, bound, start), clipped)) << "too wide";
      EXPECT_TRUE(holds(clipped, brute_triangle(terrain_.grid, column0_, row0_, t, bound - 2 * guard, start)))
          << "too narrow";
      narrowed += !clipped.empty() && (clipped.lo > start.lo || clipped.hi < start.hi) ? 1 : 0;
    }
    EXPECT_GT(narrowed, rounds / 20);
    EXPECT_FALSE(view.error().has_value());
  }

  Terrain terrain_;
  std::mt19937 random_{17};
  std::int64_t column0_ = 0;
  std::int64_t row0_ = 0;
};

TEST_P(SurfaceDistanceTest, SmallTrianglesMatchBruteForce) { compare(30, 300); }

TEST_P(SurfaceDistanceTest, TrianglesOfSeveralSquaresMatchBruteForce) { compare(400, 200); }

TEST_P(SurfaceDistanceTest, TrianglesAcrossBlocksMatchBruteForce) { compare(2400, 200); }

TEST_P(SurfaceDistanceTest, SoItIsFromAnotherOrigin) {
  column0_ = 130;
  row0_ = 37;
  compare(900, 200);
}

/// Samples and anti-diagonal crossings of a closed triangle whose edges run along the grid's eight directions.
SurfaceDistance::Fit brute_fit(const HeightGrid& grid, const std::array<Vertex, 3>& t, double bound) {
  const auto& [a, b, c] = t;
  const auto area = static_cast<double>(cross(a, b, c.x, c.y));
  const auto height = [&](std::int64_t x4, std::int64_t y4) {
    return (static_cast<double>(cross(b, c, x4, y4)) * a.z + static_cast<double>(cross(c, a, x4, y4)) * b.z +
            static_cast<double>(cross(a, b, x4, y4)) * c.z) /
           area;
  };
  bool any = false;
  bool within = true;
  const auto [left, right] = std::minmax({a.x, b.x, c.x});
  const auto [top, bottom] = std::minmax({a.y, b.y, c.y});
  for (std::int64_t y = top; y <= bottom; y += 4) {
    for (std::int64_t x = left; x <= right; x += 4) {
      const double signs[3] = {static_cast<double>(cross(a, b, x, y)) * area,
                               static_cast<double>(cross(b, c, x, y)) * area,
                               static_cast<double>(cross(c, a, x, y)) * area};
      if (std::ranges::min(signs) < 0) continue;
      const double h = grid.at(x / 4, y / 4);
      any = any || !std::isnan(h);
      within = within && std::abs(h - height(x, y)) <= bound;
    }
  }
  if (!any) return SurfaceDistance::Fit::kMissing;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vertex& p = t[k];
    const Vertex& q = t[(k + 1) % 3];
    if ((q.x - p.x) * (q.y - p.y) >= 0) continue;
    const std::int64_t step = q.x > p.x ? 4 : -4;
    for (std::int64_t x = p.x; x != q.x; x += step) {
      const std::int64_t mx = x + step / 2;
      const std::int64_t my = p.y - (mx - p.x);
      const double surface = (grid.at((mx - 2) / 4, (my - 2) / 4) + grid.at((mx + 2) / 4, (my + 2) / 4)) / 2;
      within = within && std::abs(surface - height(mx, my)) <= bound;
    }
  }
  return within ? SurfaceDistance::Fit::kWithin : SurfaceDistance::Fit::kBeyond;
}

TEST_P(SurfaceDistanceTest, FixedTrianglesMatchBruteForce) {
  // A quarter of the raster is missing, so that whole triangles are.
  const auto height = test::rough_hills(10, 1, GetParam(), 1);
  terrain_ =
      test::make_terrain(600, 300, [&](int c, int r) { return c > 300 && r < 150 ? test::kMissing : height(c, r); });
  SurfaceView view(*terrain_.surface);
  SurfaceDistance distance(view, 0, 0);
  std::array<int, 3> seen{};
  for (int round = 0; round < 3000; ++round) {
    const std::int64_t side = std::int64_t{2} << random_() % 8;
    const auto corner = [&](std::int64_t samples) {
      return std::int64_t{4} * static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(samples));
    };
    const std::int64_t x = corner(600 - side);
    const std::int64_t y = corner(300 - side);
    const std::int64_t s = 4 * side;
    const std::array<Vertex, 5> points{
        {{x, y, 0}, {x + s, y, 0}, {x, y + s, 0}, {x + s, y + s, 0}, {x + s / 2, y + s / 2, 0}}};
    // Two corners of the square and either a third one or the centre.
    constexpr std::array<std::array<std::size_t, 3>, 8> kChoices{
        {{0, 3, 1}, {0, 3, 2}, {1, 2, 0}, {1, 2, 3}, {0, 1, 4}, {2, 3, 4}, {0, 2, 4}, {1, 3, 4}}};
    std::array<Vertex, 3> t{};
    for (std::size_t k = 0; k < 3; ++k) t[k] = settle(points[kChoices[round % 8][k]], 0.1);
    const double bound = 0.7 * std::pow(2.0, std::uniform_real_distribution<double>(0, 5)(random_));
    const auto expected = brute_fit(terrain_.grid, t, bound);
    EXPECT_EQ(distance.fit_triangle(t[0].point(), t[1].point(), t[2].point(), bound), expected) << "round " << round;
    ++seen[static_cast<std::size_t>(expected)];
  }
  for (const int count : seen) EXPECT_GT(count, 50);
}

INSTANTIATE_TEST_SUITE_P(Holes, SurfaceDistanceTest, testing::Values(0.0, 0.0005, 0.2), [](const auto& holes) {
  return holes.index == 0 ? "None" : holes.index == 1 ? "Few" : "Many";
});

TEST(SurfaceHeight, IsTheReferenceSurface) {
  const Terrain terrain = test::make_terrain(40, 30, test::rough_hills(20, 2, 0.1));
  SurfaceView view(*terrain.surface);
  SurfaceDistance distance(view, 3, 5);
  for (int y = 0; y <= 4 * 24; ++y) {
    for (int x = 0; x <= 4 * 36; ++x) {
      const double found = distance.height_at(x / 4.0, y / 4.0);
      const double expected = terrain.grid.surface(3 + x / 4.0, 5 + y / 4.0);
      EXPECT_EQ(std::isnan(found), std::isnan(expected)) << x << ' ' << y;
      if (std::isnan(found)) continue;
      EXPECT_NEAR(found, expected, 1e-12);
    }
  }
}

TEST(SurfaceDistanceCases, ASampleHardByTheOuterSideCounts) {
  // (999, 1) lies a thousandth of a sample off the long side; its hub weight is 1e-6.
  const Terrain terrain =
      test::make_terrain(1101, 1002, [](int c, int r) { return c == 999 && r == 1 ? 1000.0 : 0.0; });
  SurfaceView view(*terrain.surface);
  SurfaceDistance distance(view, 0, 0);
  HeightInterval interval{-1, 1};
  distance.clip_triangle({1000, 1001, 0}, {0, 0, 0}, {1000, 1, 0}, 1, interval);
  EXPECT_TRUE(interval.empty());
}

}  // namespace
}  // namespace tintree::simplify
