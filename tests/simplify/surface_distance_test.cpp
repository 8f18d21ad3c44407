/// The checks by star against the definitions, sample by sample and crossing by crossing.

#include "simplify/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/simplify/brute_distance.h"
#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

using test::HeightGrid;
using test::QuarterPoint;
using test::Terrain;

/// A star in quarters of a sample. Its spokes end at the ring's corners.
struct BruteStar {
  QuarterPoint hub;
  std::vector<QuarterPoint> ring;
  bool closed;

  std::size_t sides() const { return closed ? ring.size() : ring.size() - 1; }
  std::array<QuarterPoint, 3> triangle(std::size_t k) const { return {hub, ring[k], ring[(k + 1) % ring.size()]}; }
};

class SurfaceDistanceTest : public testing::TestWithParam<double> {
 protected:
  static constexpr int kColumns = 1100;
  static constexpr int kRows = 600;

  SurfaceDistanceTest() : terrain_(test::make_terrain(kColumns, kRows, test::rough_hills(40, 1.5, GetParam(), 3))) {}

  std::int64_t pick(std::int64_t low, std::int64_t high) {
    return std::uniform_int_distribution<std::int64_t>(low, high)(random_);
  }
  double pick_real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  /// Puts a point into the raster and near the surface.
  QuarterPoint settle(std::int64_t x, std::int64_t y, double spread_m) {
    QuarterPoint v{std::clamp<std::int64_t>(x, -4 * column0_, 4 * (kColumns - 1 - column0_)),
                   std::clamp<std::int64_t>(y, -4 * row0_, 4 * (kRows - 1 - row0_)), 0};
    const Point p = v.point();
    const double h = terrain_.grid.surface(static_cast<double>(column0_) + p.x, static_cast<double>(row0_) + p.y);
    v.z = (std::isnan(h) ? 0 : h) + pick_real(-spread_m, spread_m);
    return v;
  }

  /// A hub and three to nine corners around it, at most `reach` samples away; now clockwise, now the other way.
  BruteStar random_star(std::int64_t reach, double spread_m) {
    // Whole samples as in every tile, or quarters as the lattice may have them.
    const std::int64_t mask = pick(0, 2) > 0 ? ~std::int64_t{3} : ~std::int64_t{0};
    BruteStar star{settle(pick(-4 * column0_, 4 * (kColumns - column0_)) & mask,
                          pick(-4 * row0_, 4 * (kRows - row0_)) & mask, spread_m),
                   {},
                   pick(0, 3) > 0};
    const std::int64_t corners = pick(3, 9);
    const double turn = pick_real(0, 1);
    for (std::int64_t k = 0; k < corners; ++k) {
      const double angle =
          2 * std::numbers::pi * (static_cast<double>(k) + turn + pick_real(0, 0.7)) / static_cast<double>(corners);
      const double radius = 4 * static_cast<double>(reach) * pick_real(0.1, 1);
      star.ring.push_back(settle((star.hub.x + std::lround(radius * std::cos(angle))) & mask,
                                 (star.hub.y + std::lround(radius * std::sin(angle))) & mask, spread_m));
    }
    if (pick(0, 1) == 0) std::ranges::reverse(star.ring);
    return star;
  }

  HeightInterval brute(const BruteStar& star, double bound, const std::vector<double>& spoke_bounds,
                       HeightInterval interval) const {
    const test::BruteSurface surface{terrain_.grid, column0_, row0_};
    for (std::size_t k = 0; k < star.sides(); ++k)
      interval = test::brute_triangle(surface, star.triangle(k), bound, interval);
    for (std::size_t k = 0; k < star.ring.size(); ++k)
      interval = test::brute_spoke(surface, star.hub, star.ring[k], spoke_bounds[k], interval);
    return interval;
  }

  static bool degenerate(const BruteStar& star) {
    for (std::size_t k = 0; k < star.sides(); ++k) {
      const auto [hub, from, to] = star.triangle(k);
      if (test::cross(hub, from, to.x, to.y) == 0) return true;
    }
    return false;
  }

  /// What a triangle may lose beyond the guard: the rounding of heights and weights over all of its extent.
  static double rounding_m(const BruteStar& star, double bound) {
    double most = 0;
    for (std::size_t k = 0; k < star.sides(); ++k) {
      const TrianglePlane plane(star.triangle(k)[0].point(), star.triangle(k)[1].point(), star.triangle(k)[2].point());
      const Extent extent = plane.extent;
      std::vector<double> heights;
      std::vector<double> weights;
      for (const double x : {extent.x0, extent.x1}) {
        for (const double y : {extent.y0, extent.y1}) {
          heights.push_back(plane.height(x, y));
          weights.push_back(plane.weight(x, y));
        }
      }
      const auto span = [](const std::vector<double>& v) { return std::ranges::max(v) - std::ranges::min(v); };
      most = std::max(most, guard_m(span(heights) + span(weights) * bound, 0));
    }
    return most;
  }

  /// Whether the sides opposite to the hub keep the bound, as old edges do; nothing is promised about others.
  bool outline_holds(const BruteStar& star, double bound) const {
    for (std::size_t k = 0; k < star.sides(); ++k) {
      const auto [hub, from, to] = star.triangle(k);
      const std::int64_t steps = std::gcd(to.x - from.x, to.y - from.y);
      for (std::int64_t i = 0; i <= steps; ++i) {
        const std::int64_t x = from.x + (to.x - from.x) / steps * i;
        const std::int64_t y = from.y + (to.y - from.y) / steps * i;
        if (x % 4 != 0 || y % 4 != 0) continue;
        const double z = from.z + (to.z - from.z) * static_cast<double>(i) / static_cast<double>(steps);
        if (std::abs(terrain_.grid.at(column0_ + x / 4, row0_ + y / 4) - z) > bound) return false;
      }
    }
    return true;
  }

  /// Stars and bounds such that some checks pass, some fail and some narrow the interval.
  void compare(std::int64_t reach, int rounds) {
    SurfaceView view(*terrain_.surface);
    SurfaceDistance distance(view, column0_, row0_);
    int narrowed = 0;
    int emptied = 0;
    int kept = 0;
    int framed = 0;
    for (int round = 0; round < rounds; ++round) {
      const double bound = std::pow(2.0, pick_real(1, 7.5));
      const double guard = bound - tested_bound_m(*terrain_.surface, {0, 0, kColumns - 1, kRows - 1}, bound);
      const BruteStar star = random_star(reach, bound / 2);
      if (degenerate(star)) continue;
      Star tested{star.hub.point(), bound - guard, {}, {}};
      const double margin = guard + rounding_m(star, bound);
      std::vector<double> most;
      std::vector<double> least;
      for (std::size_t k = 0; k < star.sides(); ++k)
        tested.sides.push_back({star.triangle(k)[1].point(), star.triangle(k)[2].point()});
      for (const QuarterPoint& end : star.ring) {
        // The line of a ribbon has a bound of its own.
        const double share = pick(0, 4) == 0 ? 0.5 : 1;
        tested.spokes.push_back({end.point(), share * bound - guard});
        most.push_back(share * bound);
        least.push_back(share * bound - guard - margin);
      }
      const HeightInterval start = round % 4 == 0 ? HeightInterval{0, 0} : HeightInterval{-bound, bound};
      HeightInterval found = start;
      distance.clip_star(tested, found);
      EXPECT_TRUE(test::holds(brute(star, bound, most, start), found)) << "too wide in round " << round;
      if (outline_holds(star, bound - guard - margin)) {
        EXPECT_TRUE(test::holds(found, brute(star, bound - guard - margin, least, start)))
            << "too narrow in round " << round;
        ++framed;
      }
      ++(found.empty() ? emptied : found.lo > start.lo || found.hi < start.hi ? narrowed : kept);
    }
    EXPECT_GT(narrowed, rounds / 20);
    EXPECT_GT(emptied, rounds / 20);
    EXPECT_GT(kept, 0);
    EXPECT_GT(framed, rounds / 4);
    EXPECT_FALSE(view.error().has_value());
  }

  Terrain terrain_;
  std::mt19937 random_{17};
  std::int64_t column0_ = 0;
  std::int64_t row0_ = 0;
};

TEST_P(SurfaceDistanceTest, SmallStarsMatchBruteForce) { compare(10, 1500); }

TEST_P(SurfaceDistanceTest, StarsAboutTheSizeOfASquareMatchBruteForce) { compare(30, 600); }

TEST_P(SurfaceDistanceTest, StarsOfManySquaresMatchBruteForce) { compare(150, 150); }

TEST_P(SurfaceDistanceTest, StarsAcrossBlocksMatchBruteForce) { compare(700, 60); }

TEST_P(SurfaceDistanceTest, SoItIsFromAnotherOrigin) {
  column0_ = 130;
  row0_ = 37;
  compare(60, 300);
  compare(300, 80);
}

TEST_P(SurfaceDistanceTest, SliversKeepTheGuard) {
  // Planes so steep that, beside the triangle, they lie far off all heights.
  terrain_ = test::make_terrain(300, 300, [](int c, int r) { return 500 * test::noise(c, r); });
  SurfaceView view(*terrain_.surface);
  SurfaceDistance distance(view, 0, 0);
  int slivers = 0;
  for (int round = 0; round < 200000 && slivers < 3000; ++round) {
    const double bound = pick_real(200, 500);
    const auto near = [&](std::int64_t from) { return std::clamp<std::int64_t>(from + 4 * pick(-23, 23), 0, 4 * 299); };
    const QuarterPoint hub = settle(4 * pick(0, 299), 4 * pick(0, 299), 1);
    const std::array<QuarterPoint, 3> t{hub, settle(near(hub.x), near(hub.y), 1), settle(near(hub.x), near(hub.y), 1)};
    const std::int64_t doubled_area = std::abs(test::cross(t[0], t[1], t[2].x, t[2].y)) / 16;
    if (doubled_area == 0 || doubled_area > 6) continue;
    ++slivers;
    HeightInterval found{-bound, bound};
    const double tested = tested_bound_m(*terrain_.surface, {0, 0, 299, 299}, bound);
    distance.clip_star({hub.point(), tested, {{t[1].point(), t[2].point()}}, {}}, found);
    EXPECT_TRUE(test::holds(test::brute_triangle({terrain_.grid}, t, bound, {-bound, bound}), found));
  }
  EXPECT_GT(slivers, 1000);
}

TEST_P(SurfaceDistanceTest, OneObjectForStarsOfAllSizes) {
  // What a star that was given up leaves behind must not show in the next.
  SurfaceView view(*terrain_.surface);
  SurfaceDistance used(view, 0, 0);
  for (int round = 0; round < 300; ++round) {
    const double bound = std::pow(2.0, pick_real(1, 7));
    const BruteStar star = random_star(std::int64_t{8} << pick(0, 6), bound / 2);
    if (degenerate(star)) continue;
    Star tested{star.hub.point(), bound, {}, {}};
    for (std::size_t k = 0; k < star.sides(); ++k)
      tested.sides.push_back({star.triangle(k)[1].point(), star.triangle(k)[2].point()});
    HeightInterval a{-bound, bound};
    HeightInterval b = a;
    used.clip_star(tested, a);
    SurfaceDistance(view, 0, 0).clip_star(tested, b);
    EXPECT_EQ(a.lo, b.lo);
    EXPECT_EQ(a.hi, b.hi);
  }
}

/// Samples and anti-diagonal crossings of a closed triangle whose edges run along the grid's eight directions.
SurfaceDistance::Fit brute_fit(const HeightGrid& grid, const std::array<QuarterPoint, 3>& t, double bound) {
  const auto& [a, b, c] = t;
  const auto area = static_cast<double>(test::cross(a, b, c.x, c.y));
  const auto height = [&](std::int64_t x4, std::int64_t y4) {
    return (static_cast<double>(test::cross(b, c, x4, y4)) * a.z +
            static_cast<double>(test::cross(c, a, x4, y4)) * b.z +
            static_cast<double>(test::cross(a, b, x4, y4)) * c.z) /
           area;
  };
  bool any = false;
  bool within = true;
  const auto [left, right] = std::minmax({a.x, b.x, c.x});
  const auto [top, bottom] = std::minmax({a.y, b.y, c.y});
  for (std::int64_t y = top; y <= bottom; y += 4) {
    for (std::int64_t x = left; x <= right; x += 4) {
      const double signs[3] = {static_cast<double>(test::cross(a, b, x, y)) * area,
                               static_cast<double>(test::cross(b, c, x, y)) * area,
                               static_cast<double>(test::cross(c, a, x, y)) * area};
      if (std::ranges::min(signs) < 0) continue;
      const double h = grid.at(x / 4, y / 4);
      any = any || !std::isnan(h);
      within = within && std::abs(h - height(x, y)) <= bound;
    }
  }
  if (!any) return SurfaceDistance::Fit::kMissing;
  for (std::size_t k = 0; k < 3; ++k) {
    const QuarterPoint& p = t[k];
    const QuarterPoint& q = t[(k + 1) % 3];
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

/// One of the right triangles in a square of side s: two corners and either a third one or the centre; at height 0.
std::array<QuarterPoint, 3> fit_choice(std::int64_t x, std::int64_t y, std::int64_t s, int which) {
  const std::array<QuarterPoint, 5> points{
      {{x, y, 0}, {x + s, y, 0}, {x, y + s, 0}, {x + s, y + s, 0}, {x + s / 2, y + s / 2, 0}}};
  constexpr std::array<std::array<std::size_t, 3>, 8> kChoices{
      {{0, 3, 1}, {0, 3, 2}, {1, 2, 0}, {1, 2, 3}, {0, 1, 4}, {2, 3, 4}, {0, 2, 4}, {1, 3, 4}}};
  const auto& [a, b, c] = kChoices[static_cast<std::size_t>(which % 8)];
  return {points[a], points[b], points[c]};
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
    std::array<QuarterPoint, 3> t = fit_choice(x, y, s, round);
    for (QuarterPoint& p : t) p = settle(p.x, p.y, 0.1);
    const double bound = 0.7 * std::pow(2.0, pick_real(0, 5));
    const auto expected = brute_fit(terrain_.grid, t, bound);
    EXPECT_EQ(distance.fit_triangle(t[0].point(), t[1].point(), t[2].point(), bound), expected) << "round " << round;
    ++seen[static_cast<std::size_t>(expected)];
  }
  for (const int count : seen) EXPECT_GT(count, 50);
}

TEST_P(SurfaceDistanceTest, TrianglesAtTheRastersEdgeMatchBruteForce) {
  // Squares of the start mesh stick out of the raster; flat ground at height 0 is what a missing corner stands for.
  for (const bool flat : {true, false}) {
    const auto hills = test::rough_hills(10, 1, GetParam(), 1);
    terrain_ =
        test::make_terrain(273, 161, [&](int c, int r) { return flat && !std::isnan(hills(c, r)) ? 0 : hills(c, r); });
    SurfaceView view(*terrain_.surface);
    SurfaceDistance distance(view, 0, 0);
    std::array<int, 3> seen{};
    for (int round = 0; round < 2000; ++round) {
      const std::int64_t side = std::int64_t{2} << pick(0, 6);
      const std::int64_t s = 4 * side;
      const std::int64_t x = s * pick(272 / side - 2, 272 / side + 1);
      const std::int64_t y = s * pick(160 / side - 2, 160 / side + 1);
      const std::array<QuarterPoint, 3> t = fit_choice(x, y, s, round);
      const auto expected = brute_fit(terrain_.grid, t, 2);
      EXPECT_EQ(distance.fit_triangle(t[0].point(), t[1].point(), t[2].point(), 2), expected)
          << x / 4 << ' ' << y / 4 << " side " << side;
      ++seen[static_cast<std::size_t>(expected)];
    }
    EXPECT_GT(seen[1], 20);
    EXPECT_GT(seen[2], 20);
    EXPECT_TRUE(seen[0] > 20 || GetParam() > 0.1);
  }
}

INSTANTIATE_TEST_SUITE_P(Holes, SurfaceDistanceTest, testing::Values(0.0, 0.0005, 0.2), [](const auto& holes) {
  return holes.index == 0 ? "None" : holes.index == 1 ? "Few" : "Many";
});

/// One triangle with a side opposite to the hub.
HeightInterval clip_triangle(SurfaceDistance& distance, const Point& hub, const Point& b, const Point& c,
                             double bound_m, HeightInterval interval) {
  distance.clip_star({hub, bound_m, {{b, c}}, {}}, interval);
  return interval;
}

TEST(SurfaceDistanceCases, ASampleHardByTheOuterSideCounts) {
  // (999, 1) lies a thousandth of a sample off the long side; its hub weight is 1e-6.
  const Terrain terrain =
      test::make_terrain(1101, 1002, [](int c, int r) { return c == 999 && r == 1 ? 1000.0 : 0.0; });
  SurfaceView view(*terrain.surface);
  SurfaceDistance distance(view, 0, 0);
  EXPECT_TRUE(clip_triangle(distance, {1000, 1001, 0}, {0, 0, 0}, {1000, 1, 0}, 1, {-1, 1}).empty());
}

TEST(SurfaceDistanceCases, ASampleHardByTheOuterSideCountsBetweenQuarters) {
  // On quarters the same happens under smaller triangles: (250, 1) has a weight of 5e-7.
  const Terrain terrain = test::make_terrain(600, 600, [](int c, int r) { return c == 250 && r == 1 ? 1000.0 : 0.0; });
  SurfaceView view(*terrain.surface);
  SurfaceDistance distance(view, 0, 0);
  EXPECT_TRUE(clip_triangle(distance, {200, 400, 0}, {0.25, 0, 0}, {312.5, 1.25, 0}, 1, {-1, 1}).empty());
}

TEST(SurfaceDistanceCases, ASpikeAnywhereUnderALargeTriangleCounts) {
  for (const auto& [column, row] :
       {std::pair{2, 1}, {15, 16}, {16, 16}, {255, 256}, {256, 256}, {300, 511}, {512, 512}}) {
    const Terrain terrain =
        test::make_terrain(600, 600, [&](int c, int r) { return c == column && r == row ? 1000.0 : 0.0; });
    SurfaceView view(*terrain.surface);
    SurfaceDistance distance(view, 0, 0);
    EXPECT_EQ(clip_triangle(distance, {0, 0, 0}, {0, 590, 0}, {599, 599, 0}, 1, {-1, 1}).empty(), column <= row);
    EXPECT_EQ(clip_triangle(distance, {0, 0, 0}, {599, 599, 0}, {599, 0, 0}, 1, {-1, 1}).empty(), column >= row);
  }
}

TEST(SurfaceDistanceCases, TheGuardGrowsWithReliefAndBound) {
  EXPECT_EQ(guard_m(0, 1), 1e-6);
  EXPECT_GT(guard_m(1000, 1), guard_m(100, 1));
  const Terrain terrain = test::make_terrain(600, 40, [](int c, int) { return c > 300 ? 1000.0 : 0.0; });
  const double far = 1000 * 0x1p-46;
  EXPECT_EQ(tested_bound_m(*terrain.surface, {0, 0, 100, 39}, 2), 2 - guard_m(0, 2));
  EXPECT_EQ(tested_bound_m(*terrain.surface, {260, 0, 270, 39}, 2), 2 - guard_m(1000, 2) - far);
  EXPECT_EQ(tested_bound_m(*terrain.surface, {100, 0, 256, 39}, 2), 2 - guard_m(1000, 2) - far)
      << "the next block has the last samples too";
}

TEST(SurfaceDistanceCases, TheGuardGoesByTheReliefOfBlocksAlone) {
  // Two plateaus, each a block of its own.
  const Terrain terrain = test::make_terrain(600, 40, [](int c, int) {
    return c > 250 && c < 260 ? test::kMissing : c < 256 ? -1e6 : 1e6 + c % 2;
  });
  EXPECT_EQ(tested_bound_m(*terrain.surface, {0, 0, 599, 39}, 2), 2 - guard_m(1, 2) - 1000001 * 0x1p-46);
}

}  // namespace
}  // namespace tintree::simplify
