/// The start mesh against brute force: sound in each tile, and one and the same mesh on both sides of every side.

#include "simplify/right_triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"
#include "tests/support/adversarial_terrain.h"

namespace tintree::simplify {
namespace {

using test::AdversarialTerrain;
using test::Terrain;

/// A triangle by its corners' places and height steps, relative to the DEM's first sample, the same one first.
using PlacedTriangle = std::array<std::array<std::int64_t, 3>, 3>;

std::set<PlacedTriangle> placed(const StartMesh& mesh, std::int64_t column0, std::int64_t row0) {
  std::set<PlacedTriangle> out;
  for (const auto& t : mesh.triangles) {
    PlacedTriangle corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const LatticeVertex& v = mesh.vertices[static_cast<std::size_t>(t[k])];
      corners[k] = {v.x + column0, v.y + row0, mesh.heights.origin + v.z};
    }
    std::ranges::rotate(corners, std::ranges::min_element(corners));
    EXPECT_TRUE(out.insert(corners).second) << "a triangle twice";
  }
  return out;
}

/// One tile's start mesh, and the means to look at it.
class Start {
 public:
  Start(const Terrain& terrain, std::int64_t tile_x, std::int64_t tile_y, std::int64_t cells, double bound_m)
      : terrain_(terrain),
        column0_(tile_x * cells),
        row0_(tile_y * cells),
        level_{cells, bound_m, {bound_m / 4}},
        view_(*terrain.surface),
        start_(view_, level_, column0_, row0_),
        mesh_(start_.tile()) {}

  /// One that keeps the bound, and half of it along the tile's sides.
  void expect_sound() {
    expect_conforming();
    expect_snapped();
    const test::Overlay found = measure();
    EXPECT_LE(found.coverage_error, 1e-9);
    EXPECT_LE(found.max_m, level_.bound_m * (1 + 1e-12));
    EXPECT_LE(found.border_max_m, level_.bound_m / 2 * (1 + 1e-12));
    for (const Side& side : sides()) expect_band_is_part(side);
  }

  std::size_t triangles() const { return mesh_.triangles.size(); }

  std::array<Side, 4> sides() const {
    const std::int64_t n = level_.cells;
    return {{{column0_, row0_, n, false},
             {column0_, row0_ + n, n, false},
             {column0_, row0_, n, true},
             {column0_ + n, row0_, n, true}}};
  }

  RightTriangleMesh& mesh() { return start_; }

 private:
  /// The mesh as a tile, for the brute-force overlay.
  test::Overlay measure() const {
    codec::TreeLayout layout;
    layout.columns = terrain_.grid.columns - column0_;
    layout.rows = terrain_.grid.rows - row0_;
    layout.tile_cells = static_cast<int>(level_.cells);
    layout.z_step_m = {level_.heights.step_m};
    codec::TileMesh tile;
    tile.z_offset = mesh_.heights.origin;
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
    const auto cells = static_cast<double>(level_.cells);
    for (const auto& [from, to] : edges) {
      if (edges.contains({to, from})) continue;
      const LatticeVertex& a = mesh_.vertices[static_cast<std::size_t>(from)];
      const LatticeVertex& b = mesh_.vertices[static_cast<std::size_t>(to)];
      // The half cell at the edge's middle on its right: a step away from it, at a right angle.
      const double length = std::hypot(b.x - a.x, b.y - a.y);
      const double x = (a.x + b.x) / 2.0 + 0.01 * (b.y - a.y) / length * -1 + 0.003 * (b.x - a.x) / length;
      const double y = (a.y + b.y) / 2.0 + 0.01 * (b.x - a.x) / length + 0.003 * (b.y - a.y) / length;
      if (x < 0 || y < 0 || x > cells || y > cells) continue;
      const double fx = x - std::floor(x);
      const double fy = y - std::floor(y);
      EXPECT_FALSE(exists(static_cast<std::int64_t>(x), static_cast<std::int64_t>(y), fx > fy))
          << "a gap at " << x << ' ' << y;
    }
  }

  void expect_snapped() const {
    for (const LatticeVertex& v : mesh_.vertices)
      EXPECT_EQ(mesh_.heights.origin + v.z, level_.heights.address(terrain_.grid.at(column0_ + v.x, row0_ + v.y)));
  }

  /// The band's half in this tile: those of its triangles that touch the side and lie within 45 degrees of its ends.
  void expect_band_is_part(const Side& side) {
    std::array<bool, 2> open_ends{};
    std::set<PlacedTriangle> half;
    for (const PlacedTriangle& t : placed(start_.band(side, open_ends), side.column, side.row)) {
      EXPECT_TRUE(std::ranges::any_of(t, [&](const auto& p) { return across(side, p) == 0; })) << "does not touch";
      const bool here = std::ranges::all_of(t, [&](const auto& p) {
        return p[0] >= column0_ && p[1] >= row0_ && p[0] <= column0_ + level_.cells && p[1] <= row0_ + level_.cells;
      });
      if (here) half.insert(t);
    }
    std::set<PlacedTriangle> expected;
    for (const PlacedTriangle& t : placed(mesh_, column0_, row0_)) {
      const bool touches = std::ranges::any_of(t, [&](const auto& p) { return across(side, p) == 0; });
      const bool in_cut = std::ranges::all_of(t, [&](const auto& p) {
        const std::int64_t along = side.southward ? p[1] - side.row : p[0] - side.column;
        return std::abs(across(side, p)) <= std::min(along, side.cells - along);
      });
      if (touches && in_cut) expected.insert(t);
    }
    EXPECT_EQ(half, expected) << "side at " << side.column << ' ' << side.row;
  }

  static std::int64_t across(const Side& side, const std::array<std::int64_t, 3>& p) {
    return side.southward ? p[0] - side.column : p[1] - side.row;
  }

  const Terrain& terrain_;
  std::int64_t column0_;
  std::int64_t row0_;
  LevelGrid level_;
  SurfaceView view_;
  RightTriangleMesh start_;
  StartMesh mesh_;
};

/// The band of a common side is the same mesh whoever asks, vertex by vertex and triangle by triangle.
void expect_same_band(Start& a, Start& b, const Side& side) {
  std::array<bool, 2> open_a{};
  std::array<bool, 2> open_b{};
  const StartMesh band_a = a.mesh().band(side, open_a);
  const StartMesh band_b = b.mesh().band(side, open_b);
  EXPECT_EQ(open_a, open_b);
  EXPECT_EQ(band_a.triangles, band_b.triangles);
  EXPECT_EQ(band_a.heights.origin, band_b.heights.origin);
  EXPECT_EQ(band_a.vertices, band_b.vertices);
}

void expect_one_mesh(const Terrain& terrain, std::int64_t cells, double bound_m) {
  SCOPED_TRACE("tiles of " + std::to_string(cells) + ", bound " + std::to_string(bound_m));
  const std::int64_t across = std::min<std::int64_t>(4, (terrain.grid.columns - 2) / cells + 1);
  const std::int64_t down = std::min<std::int64_t>(3, (terrain.grid.rows - 2) / cells + 1);
  for (std::int64_t y = 0; y < down; ++y) {
    for (std::int64_t x = 0; x < across; ++x) {
      Start here(terrain, x, y, cells, bound_m);
      Start east(terrain, x + 1, y, cells, bound_m);
      Start south(terrain, x, y + 1, cells, bound_m);
      expect_same_band(here, east, here.sides()[3]);
      expect_same_band(here, south, here.sides()[1]);
    }
  }
}

class RightTriangleMeshTest : public testing::TestWithParam<AdversarialTerrain> {};

TEST_P(RightTriangleMeshTest, IsSoundAtEveryBound) {
  const Terrain terrain = test::make_terrain(GetParam().columns, GetParam().rows, GetParam().height);
  for (const double bound : {0.05, 2.0, 60.0}) {
    SCOPED_TRACE(bound);
    Start(terrain, 0, 0, 128, bound).expect_sound();
    Start(terrain, 1, 2, 32, bound).expect_sound();
    Start(terrain, 2, 1, 8, bound).expect_sound();
  }
}

TEST_P(RightTriangleMeshTest, NeighboursHaveOneMesh) {
  const Terrain terrain = test::make_terrain(GetParam().columns, GetParam().rows, GetParam().height);
  for (const std::int64_t cells : {8, 16, 32, 64}) {
    for (const double bound : {0.5, 8.0}) expect_one_mesh(terrain, cells, bound);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, RightTriangleMeshTest, testing::ValuesIn(test::everyday_terrains()),
                         [](const auto& shape) { return shape.param.name; });

TEST(RightTriangleMesh, NeighboursHaveOneMeshOnRandomTerrain) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    const double holes = seed % 2 == 0 ? 0 : 0.0005 * std::pow(3.0, seed / 2);
    const Terrain terrain = test::make_terrain(700, 560, test::rough_hills(30, 1, holes, seed));
    for (const std::int64_t cells : {64, 128, 256}) expect_one_mesh(terrain, cells, 0.5 * std::pow(2.0, seed % 5));
  }
}

TEST(RightTriangleMesh, IsSoundOverManySquaresOfTheResidualPyramid) {
  // Smooth enough for slabs, sums of errors and samples to decide, each somewhere; with and without voids.
  for (const double bound : {1.0, 4.0, 30.0}) {
    SCOPED_TRACE(bound);
    for (const double holes : {0.0, 0.0002}) {
      Start(test::make_terrain(700, 560, test::rough_hills(40, 0.5, holes, 2)), 0, 0, 512, bound).expect_sound();
    }
  }
}

TEST(RightTriangleMesh, CoversLowGroundUpToTheRastersEdge) {
  // The sea at height 0, next to nothing at all; the raster ends on, before and behind a line of the residual pyramid.
  for (const auto& [columns, rows] : {std::pair{529, 545}, {513, 529}, {520, 700}, {545, 513}}) {
    for (const double relief : {0.0, 3.0}) {
      SCOPED_TRACE(std::to_string(columns) + " relief " + std::to_string(relief));
      const Terrain terrain =
          test::make_terrain(columns, rows, [=](int c, int r) { return test::hills(c, r, relief); });
      Start(terrain, 0, 0, 512, 20).expect_sound();
      Start(terrain, 0, 0, 1024, 20).expect_sound();
      Start(terrain, 1, 1, 512, 20).expect_sound();
    }
  }
}

TEST(RightTriangleMesh, CoversLowGroundUpToTheEdgeOfAVoid) {
  for (const int edge : {256, 272, 277, 288}) {
    const Terrain terrain =
        test::make_terrain(545, 545, [=](int c, int r) { return c > edge && r > edge ? test::kMissing : 0.0; });
    SCOPED_TRACE(edge);
    Start(terrain, 0, 0, 512, 20).expect_sound();
    Start(terrain, 0, 0, 1024, 20).expect_sound();
  }
}

TEST(RightTriangleMesh, StopsAtOnceWhereTheSurfaceIsFlat) {
  // 16 x 16 squares of two triangles each, whatever the tile's size.
  for (const std::int64_t cells : {16, 64, 512}) {
    const Terrain terrain = test::make_terrain(2 * static_cast<int>(cells) + 1, 2 * static_cast<int>(cells) + 1,
                                               [](int, int) { return 3.0; });
    for (std::int64_t tile = 0; tile < 2; ++tile)
      EXPECT_EQ(Start(terrain, tile, tile, cells, 1).triangles(), 2U * 16 * 16) << cells;
  }
}

TEST(RightTriangleMesh, StopsInsideATile) {
  const Terrain terrain = test::make_terrain(129, 129, [](int c, int r) { return 100 * test::noise(c, r); });
  StopFlag stop = false;
  SurfaceView view(*terrain.surface, &stop);
  RightTriangleMesh start(view, {128, 1, {0.25}}, 0, 0);
  EXPECT_EQ(start.tile().triangles.size(), 2U * 128 * 128);
  stop = true;
  EXPECT_LT(start.tile().triangles.size(), 8192U);
}

TEST(RightTriangleMesh, FlipsOnlyWhatStaysInBound) {
  const Terrain terrain = test::make_terrain(4, 3, [](int c, int r) {
    return c == 3 && r == 2 ? test::kMissing : c == 1 && r == 1 ? 8.0 : 0.0;
  });
  SurfaceView view(*terrain.surface);
  const auto may = [&](std::int64_t column, std::int64_t row, double bound_m) {
    return may_flip(view, {8, bound_m, {0.25}}, column, row);
  };
  // Half of the raised sample's height is what a flip of a cell at it changes.
  EXPECT_TRUE(may(0, 0, 4.001));
  EXPECT_FALSE(may(0, 0, 3.9));
  EXPECT_TRUE(may(1, 0, 4.001));
  EXPECT_FALSE(may(1, 0, 3.9));
  EXPECT_TRUE(may(2, 0, 0.1));
  EXPECT_FALSE(may(2, 1, 100)) << "a sample is missing";
  EXPECT_FALSE(may(3, 1, 100)) << "beyond the raster";
  EXPECT_FALSE(may(-1, 0, 100));
}

}  // namespace
}  // namespace tintree::simplify
