#include "simplify/right_triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "simplify/border_ribbon.h"
#include "simplify/split_flags.h"
#include "tests/simplify/support.h"
#include "tests/support/adversarial_terrain.h"

namespace tintree::simplify {
namespace {

using test::AdversarialTerrain;
using test::Terrain;

/// A start mesh over one square, and the means to look at it.
class Start {
 public:
  Start(const Terrain& terrain, std::int64_t column0, std::int64_t row0, std::int64_t cells, double bound_m)
      : terrain_(terrain), column0_(column0), row0_(row0), cells_(cells), bound_m_(bound_m), heights_{bound_m / 4} {
    SurfaceView view(*terrain.surface);
    SurfaceDistance distance(view, column0, row0);
    const std::int64_t last = cells - 1;
    flips_ = {may_flip(view, column0 + last, row0, bound_m, heights_),
              may_flip(view, column0, row0 + last, bound_m, heights_)};
    mesh_ = right_triangle_mesh(distance, view, column0, row0, cells, bound_m, heights_, flips_);
  }

  void expect_sound() const {
    expect_conforming();
    const test::Overlay found = measure();
    EXPECT_LE(found.coverage_error, 1e-9);
    EXPECT_LE(found.max_m, bound_m_ * (1 + 1e-6));
    expect_full_border();
    expect_sides();
  }

  std::size_t triangles() const { return mesh_.triangles.size(); }

 private:
  /// The mesh as a tile, for the brute-force overlay.
  test::Overlay measure() const {
    codec::TreeLayout layout;
    layout.columns = terrain_.grid.columns - column0_;
    layout.rows = terrain_.grid.rows - row0_;
    layout.tile_cells = static_cast<int>(cells_);
    layout.z_step_m = {heights_.step_m};
    codec::TileMesh tile;
    for (const LatticeVertex& v : mesh_.vertices) tile.vertices.push_back({v.x, v.y, v.z});
    for (const auto& t : mesh_.triangles) {
      tile.triangles.push_back(
          {static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]), static_cast<std::uint32_t>(t[2])});
    }
    test::HeightGrid part{layout.columns, layout.rows, {}};
    for (std::int64_t r = row0_; r < terrain_.grid.rows; ++r) {
      for (std::int64_t c = column0_; c < terrain_.grid.columns; ++c) part.heights_m.push_back(terrain_.grid.at(c, r));
    }
    return test::overlay(part, layout, {}, tile);
  }

  bool exists(std::int64_t x, std::int64_t y, bool upper) const {
    return upper ? terrain_.grid.has_upper(column0_ + x, row0_ + y) : terrain_.grid.has_lower(column0_ + x, row0_ + y);
  }

  /// Every directed edge once; one without its opposite has no surface on its other side.
  void expect_conforming() const {
    std::set<std::pair<std::int32_t, std::int32_t>> edges;
    for (const auto& t : mesh_.triangles) {
      for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(edges.insert({t[k], t[(k + 1) % 3]}).second);
    }
    for (const auto& [from, to] : edges) {
      if (edges.contains({to, from})) continue;
      const LatticeVertex& a = mesh_.vertices[static_cast<std::size_t>(from)];
      const LatticeVertex& b = mesh_.vertices[static_cast<std::size_t>(to)];
      // The half cell at the edge's middle on its right: a step away from it, at a right angle.
      const double length = std::hypot(b.x - a.x, b.y - a.y);
      const double x = (a.x + b.x) / 2.0 + 0.01 * (b.y - a.y) / length * -1 + 0.003 * (b.x - a.x) / length;
      const double y = (a.y + b.y) / 2.0 + 0.01 * (b.x - a.x) / length + 0.003 * (b.y - a.y) / length;
      if (x < 0 || y < 0 || x > static_cast<double>(cells_) || y > static_cast<double>(cells_)) continue;
      const double fx = x - std::floor(x);
      const double fy = y - std::floor(y);
      EXPECT_FALSE(exists(static_cast<std::int64_t>(x), static_cast<std::int64_t>(y), fx > fy))
          << "a gap at " << x << ' ' << y;
    }
  }

  /// Cells along the border are two unit triangles, with the surface's diagonal unless they are flipped.
  void expect_full_border() const {
    std::set<std::array<std::int32_t, 6>> unit;
    for (const auto& t : mesh_.triangles) unit.insert(key(t));
    const auto last = static_cast<std::int32_t>(cells_) - 1;
    for (std::int32_t y = 0; y <= last; ++y) {
      for (std::int32_t x = 0; x <= last; x += y == 0 || y == last ? 1 : last) {
        const bool flipped = (flips_.north_east && x == last && y == 0) || (flips_.south_west && x == 0 && y == last);
        const bool upper = exists(x, y, true);
        const bool lower = exists(x, y, false);
        if (flipped) {
          EXPECT_TRUE(unit.contains(sorted({{{x, y}, {x + 1, y}, {x, y + 1}}}))) << x << ' ' << y;
          EXPECT_TRUE(unit.contains(sorted({{{x + 1, y + 1}, {x + 1, y}, {x, y + 1}}}))) << x << ' ' << y;
          continue;
        }
        EXPECT_EQ(unit.contains(sorted({{{x, y}, {x + 1, y}, {x + 1, y + 1}}})), upper) << x << ' ' << y;
        EXPECT_EQ(unit.contains(sorted({{{x, y}, {x, y + 1}, {x + 1, y + 1}}})), lower) << x << ' ' << y;
      }
    }
  }

  /// The lists of side vertices name the samples that they stand for.
  void expect_sides() const {
    const auto n = static_cast<std::int32_t>(cells_);
    for (std::int32_t i = 0; i <= n; ++i) {
      const std::array<std::array<std::int32_t, 2>, 4> places{{{i, 0}, {i, n}, {0, i}, {n, i}}};
      for (std::size_t side = 0; side < 4; ++side) {
        const std::int32_t v = mesh_.sides[side][static_cast<std::size_t>(i)];
        if (v == kNone) continue;
        const LatticeVertex& p = mesh_.vertices[static_cast<std::size_t>(v)];
        EXPECT_EQ(p.x, places[side][0]);
        EXPECT_EQ(p.y, places[side][1]);
        EXPECT_EQ(p.z, heights_.snap(terrain_.grid.at(column0_ + p.x, row0_ + p.y)));
      }
    }
  }

  using Places = std::array<std::array<std::int32_t, 2>, 3>;
  static std::array<std::int32_t, 6> sorted(Places places) {
    std::ranges::sort(places);
    return {places[0][0], places[0][1], places[1][0], places[1][1], places[2][0], places[2][1]};
  }
  std::array<std::int32_t, 6> key(const std::array<std::int32_t, 3>& t) const {
    Places places{};
    for (std::size_t k = 0; k < 3; ++k) {
      const LatticeVertex& v = mesh_.vertices[static_cast<std::size_t>(t[k])];
      places[k] = {v.x, v.y};
    }
    return sorted(places);
  }

  const Terrain& terrain_;
  std::int64_t column0_;
  std::int64_t row0_;
  std::int64_t cells_;
  double bound_m_;
  HeightLattice heights_;
  CornerFlips flips_;
  StartMesh mesh_;
};

class RightTriangleMeshTest : public testing::TestWithParam<AdversarialTerrain> {};

TEST_P(RightTriangleMeshTest, IsSoundAtEveryBound) {
  const Terrain terrain = test::make_terrain(GetParam().columns, GetParam().rows, GetParam().height);
  for (const double bound : {0.05, 2.0, 60.0}) {
    SCOPED_TRACE(bound);
    Start(terrain, 0, 0, 128, bound).expect_sound();
    Start(terrain, 32, 64, 32, bound).expect_sound();
    Start(terrain, 16, 8, 8, bound).expect_sound();
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, RightTriangleMeshTest, testing::ValuesIn(test::everyday_terrains()),
                         [](const auto& shape) { return shape.param.name; });

TEST(RightTriangleMesh, StopsAtOnceWhereTheSurfaceIsFlat) {
  const Terrain terrain = test::make_terrain(513, 513, [](int, int) { return 3.0; });
  const std::size_t small = Start(terrain, 0, 0, 64, 1).triangles();
  const std::size_t large = Start(terrain, 0, 0, 512, 1).triangles();
  EXPECT_LT(small, 64U * 8 * 3);
  EXPECT_LT(large, 512U * 8 * 3);
}

TEST(SplitFlags, RankTheirBits) {
  SplitFlags flags(512);
  std::set<std::pair<std::int64_t, std::int64_t>> set;
  for (int k = 0; k < 3000; ++k) {
    const auto x = static_cast<std::int64_t>(test::noise(k, 1) * 513);
    const auto y = static_cast<std::int64_t>(test::noise(k, 2) * 513);
    EXPECT_EQ(flags.set(x, y), set.insert({x, y}).second);
  }
  EXPECT_EQ(flags.number(), static_cast<std::int32_t>(set.size()));
  std::set<std::int32_t> ranks;
  for (std::int64_t y = 0; y <= 512; ++y) {
    for (std::int64_t x = 0; x <= 512; ++x) {
      EXPECT_EQ(flags.get(x, y), set.contains({x, y}));
      if (flags.get(x, y)) ranks.insert(flags.rank(x, y));
    }
  }
  EXPECT_EQ(ranks.size(), set.size());
  EXPECT_EQ(*ranks.begin(), 0);
  EXPECT_EQ(*ranks.rbegin(), static_cast<std::int32_t>(set.size()) - 1);
}

}  // namespace
}  // namespace tintree::simplify
