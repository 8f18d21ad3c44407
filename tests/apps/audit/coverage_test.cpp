#include "apps/audit/coverage.h"

#include <random>

#include <gtest/gtest.h>

#include "apps/audit/border.h"
#include "apps/audit/topology.h"
#include "tests/apps/audit/measure_support.h"
#include "tests/apps/audit/random_tin.h"

namespace tintree::test {
namespace {

double holed(int c, int r) {
  const bool hole =
      (c == 5 && r == 5) || (c == 7 && r == 7) || (c == 0 && r == 16) || (c > 9 && c < 13 && r > 8 && r < 14);
  return hole ? kMissing : hills(c, r);
}

class CoverageTest : public testing::Test {
 protected:
  CoverageTest()
      : dem_({.columns = 17, .rows = 17}, holed),
        tree_(make_regular_tree(dem_.path, {.tile_cells = 8, .z_step_m = 1})) {}

  std::uint64_t faults(const codec::TileId& id, const codec::TileMesh& mesh) const {
    return coverage_faults(*dem_.source, audit::place(tree_.manifest.layout, id, mesh)).count;
  }

  RasterFixture dem_;
  TestTree tree_;
};

TEST_F(CoverageTest, AcceptsHolesOfAllShapes) {
  for (const cache::StoredTile& tile : tree_.tiles) {
    EXPECT_EQ(faults(tile.info.id, tree_.mesh(tile.info.id)), 0U) << tile.info.id.text();
  }
}

TEST_F(CoverageTest, CountsTheReferenceTriangles) {
  const audit::TileSurface s = audit::place(tree_.manifest.layout, {0, 0, 0}, tree_.mesh({0, 0, 0}));
  const audit::WindowBins bins(s);
  std::uint64_t counted = 0;
  for_windows(*dem_.source, s, bins, [&](const audit::HeightWindow& window, std::size_t i) {
    counted += audit::Coverage().check(s, window, bins.edges(i)).reference_triangles;
  });
  std::uint64_t expected = 0;
  for (int r = 0; r < 16; ++r) {
    for (int c = 0; c < 16; ++c) {
      expected += (dem_.grid.has_lower(c, r) ? 1U : 0U) + (dem_.grid.has_upper(c, r) ? 1U : 0U);
    }
  }
  EXPECT_EQ(counted, expected);
  EXPECT_EQ(audit::doubled_area(s), static_cast<std::int64_t>(expected));
}

TEST_F(CoverageTest, FindsEveryDroppedTriangle) {
  const codec::TileMesh whole = tree_.mesh({0, 0, 0});
  for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
    codec::TileMesh mesh = whole;
    mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t));
    EXPECT_GT(faults({0, 0, 0}, mesh), 0U) << t;
  }
}

/// A triangle over a hole, one that lies on another, and one beyond the raster.
TEST_F(CoverageTest, FindsExtraTriangles) {
  const codec::TileMesh whole = tree_.mesh({0, 0, 0});
  const auto with = [&](const std::vector<codec::GridVertex>& corners) {
    codec::TileMesh mesh = whole;
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
    mesh.triangles.push_back({first, first + 1, first + 2});
    return mesh;
  };
  EXPECT_GT(faults({0, 0, 0}, with({{10, 9, 0}, {10, 10, 0}, {11, 10, 0}})), 0U);
  EXPECT_GT(faults({0, 0, 0}, with({{1, 1, 0}, {1, 2, 0}, {2, 2, 0}})), 0U);
  EXPECT_GT(faults({0, 0, 0}, with({{16, 16, 0}, {16, 17, 0}, {17, 17, 0}})), 0U);
}

/// A gap and an overlap of equal area, which no sum of areas shows.
TEST_F(CoverageTest, FindsAGapThatAnOverlapMakesUp) {
  codec::TileMesh mesh = tree_.mesh({0, 0, 0});
  const codec::Triangle moved = mesh.triangles[40];
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const std::uint32_t v : moved) {
    codec::GridVertex p = mesh.vertices[v];
    p.x += p.x < 8 ? 1 : -1;
    mesh.vertices.push_back(p);
  }
  mesh.triangles[40] = {first, first + 1, first + 2};
  EXPECT_GT(faults({0, 0, 0}, mesh), 0U);
}

/// Two parts that meet along an edge without sharing its vertices could drift apart.
TEST_F(CoverageTest, FindsASeam) {
  codec::TileMesh mesh = tree_.mesh({1, 1, 0});
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const std::uint32_t v : mesh.triangles[30]) mesh.vertices.push_back(codec::GridVertex(mesh.vertices[v]));
  mesh.triangles[30] = {first, first + 1, first + 2};
  EXPECT_GT(faults({1, 1, 0}, mesh), 0U);
}

TEST(Coverage, AcceptsFractionalVerticesOnTheOutline) {
  const RasterFixture dem({.columns = 3, .rows = 3}, [](int c, int r) { return c == 2 && r == 0 ? kMissing : 0.0; });
  codec::TreeLayout layout;
  layout.columns = 3;
  layout.rows = 3;
  layout.tile_cells = 2;
  layout.z_step_m = {1};
  layout.leaf_error_m = 1;
  // Eighths of samples; the missing corner leaves the diagonal from (1, 0) to (2, 1), here with a vertex on it.
  codec::TileMesh mesh;
  mesh.xy_shift = -3;
  mesh.vertices = {{0, 0, 0}, {0, 16, 0}, {16, 16, 0}, {16, 8, 0}, {11, 3, 0}, {8, 0, 0}, {3, 0, 0}};
  mesh.triangles = {{0, 1, 6}, {6, 1, 5}, {5, 1, 4}, {4, 1, 3}, {3, 1, 2}};
  ASSERT_TRUE(codec::validate(mesh, 2));
  EXPECT_EQ(coverage_faults(*dem.source, audit::place(layout, {0, 0, 0}, mesh)).count, 0U);
  mesh.vertices[4] = {11, 4, 0};
  ASSERT_TRUE(codec::validate(mesh, 2));
  EXPECT_GT(coverage_faults(*dem.source, audit::place(layout, {0, 0, 0}, mesh)).count, 0U);
}

TEST(Coverage, AcceptsIrregularMeshes) {
  const RasterFixture dem({.columns = 20, .rows = 24}, [](int c, int r) { return hills(c, r); });
  const TestTree tree = make_regular_tree(dem.path, {.tile_cells = 32});
  for (const int shift : {0, -2}) {
    const codec::TileMesh mesh = random_tin(dem.grid, tree.manifest.layout, {0, 0, 0}, shift, 1, 3);
    EXPECT_EQ(coverage_faults(*dem.source, audit::place(tree.manifest.layout, {0, 0, 0}, mesh)).count, 0U);
  }
}

/// Whatever a decoder lets through is measured without harm, however senseless, and found at fault.
TEST(Coverage, SurvivesAnyTriangles) {
  const RasterFixture dem({.columns = 21, .rows = 11},
                          [](int c, int r) { return c == 3 && r == 3 ? kMissing : hills(c, r); });
  const TestTree tree = make_regular_tree(dem.path, {.tile_cells = 32});
  std::mt19937_64 random(11);
  for (int round = 0; round < 200; ++round) {
    codec::TileMesh mesh;
    mesh.xy_shift = -static_cast<int>(random() % 4);
    const std::uint64_t span = 32U << -mesh.xy_shift;
    for (int v = 0; v < 40; ++v) {
      mesh.vertices.push_back({static_cast<std::int32_t>(random() % (span + 1)),
                               static_cast<std::int32_t>(random() % (span + 1)),
                               static_cast<std::int32_t>(random() % 65536)});
    }
    for (int t = 0; t < 60; ++t) {
      const auto pick = [&random] { return static_cast<std::uint32_t>(random() % 40); };
      const codec::Triangle n{pick(), pick(), pick()};
      if (codec::doubled_area(mesh.vertices[n[0]], mesh.vertices[n[1]], mesh.vertices[n[2]]) > 0)
        mesh.triangles.push_back(n);
    }
    const audit::TileSurface surface = audit::place(tree.manifest.layout, {0, 0, 0}, mesh);
    EXPECT_GT(coverage_faults(*dem.source, surface).count, 0U);
    EXPECT_GT(audit::check_topology(surface).count, 0U);
    EXPECT_GE(measure(*dem.source, surface).overall.value_m, 0);
    audit::side_lines(surface);
  }
}

}  // namespace
}  // namespace tintree::test
