#include "apps/audit/vertical_distance.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/apps/audit/measure_support.h"
#include "tests/apps/audit/random_tin.h"
#include "tests/support/naive_measure.h"

namespace tintree::test {
namespace {

codec::TreeLayout layout_of(const RasterFixture& dem, int tile_cells, double z_step_m) {
  codec::TreeLayout layout;
  layout.columns = dem.grid.columns;
  layout.rows = dem.grid.rows;
  layout.tile_cells = tile_cells;
  layout.leaf_level = codec::TreeLayout::leaf_level_for(layout.columns, layout.rows, tile_cells);
  layout.leaf_error_m = 1;
  layout.z_step_m.assign(static_cast<std::size_t>(layout.leaf_level) + 1, z_step_m);
  return layout;
}

void expect_naive(const RasterFixture& dem, const codec::TreeLayout& layout, const codec::TileId& id,
                  const codec::TileMesh& mesh) {
  const NaiveFigures naive = naive_figures(dem.grid, layout, id, mesh);
  const audit::VerticalDistance fast = measure(*dem.source, audit::place(layout, id, mesh));
  EXPECT_NEAR(fast.overall.value_m, naive.error_m, 1e-9);
  EXPECT_NEAR(fast.border.value_m, naive.border_error_m, 1e-9);
  EXPECT_NEAR(std::sqrt(fast.sum_squares_m2 / static_cast<double>(fast.samples)), naive.rms_m, 1e-9);
}

/// Largest difference at random points of the mesh.
double random_points(const RasterFixture& dem, const codec::TreeLayout& layout, const codec::TileId& id,
                     const codec::TileMesh& mesh, int per_triangle) {
  const codec::GridFrame frame(layout, id, mesh);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> share(0, 1);
  double largest = 0;
  for (const codec::Triangle& t : mesh.triangles) {
    std::array<std::array<double, 3>, 3> p{};
    for (std::size_t k = 0; k < 3; ++k) {
      const codec::GridVertex& v = mesh.vertices[t[k]];
      p[k] = {frame.column(v.x), frame.row(v.y), frame.height_m(v.z)};
    }
    for (int i = 0; i < per_triangle; ++i) {
      double u = share(random);
      double v = share(random);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      const double column = p[0][0] + u * (p[1][0] - p[0][0]) + v * (p[2][0] - p[0][0]);
      const double row = p[0][1] + u * (p[1][1] - p[0][1]) + v * (p[2][1] - p[0][1]);
      largest = std::max(largest, std::abs(plane_height(p, column, row) - dem.grid.surface(column, row)));
    }
  }
  return largest;
}

TEST(VerticalDistance, IsZeroOnTheSurfaceItself) {
  const RasterFixture dem({.columns = 20, .rows = 13}, [](int c, int r) { return std::round(hills(c, r)); });
  const TestTree tree = make_regular_tree(dem.path, {.tile_cells = 32, .z_step_m = 0.5});
  const audit::VerticalDistance d =
      measure(*dem.source, audit::place(tree.manifest.layout, {0, 0, 0}, tree.mesh({0, 0, 0})));
  EXPECT_EQ(d.overall.value_m, 0);
  EXPECT_EQ(d.border.value_m, 0);
  EXPECT_EQ(d.sum_squares_m2, 0);
  EXPECT_EQ(d.samples, 20U * 13U);
}

/// A mesh exact at every sample can still cut through the surface: a flipped diagonal over a saddle.
TEST(VerticalDistance, SeesBetweenTheSamples) {
  const RasterFixture dem({.columns = 2, .rows = 2}, [](int c, int r) { return c == r ? 10.0 : 0.0; });
  const codec::TreeLayout layout = layout_of(dem, 1, 1);
  const codec::TileMesh flipped{0, 0, {{0, 0, 10}, {1, 0, 0}, {0, 1, 0}, {1, 1, 10}}, {{0, 2, 1}, {1, 2, 3}}};
  ASSERT_TRUE(codec::validate(flipped, 1));
  const audit::VerticalDistance d = measure(*dem.source, audit::place(layout, {0, 0, 0}, flipped));
  EXPECT_DOUBLE_EQ(d.overall.value_m, 10);
  EXPECT_DOUBLE_EQ(d.overall.column, 0.5);
  EXPECT_DOUBLE_EQ(d.overall.row, 0.5);
  EXPECT_EQ(d.sum_squares_m2, 0);
  EXPECT_EQ(d.border.value_m, 0);
}

class RandomTin : public testing::TestWithParam<int> {};

TEST_P(RandomTin, MatchesBruteForceAndBoundsEveryPoint) {
  const int seed = GetParam();
  const RasterFixture dem({.columns = 33, .rows = 29}, [seed](int c, int r) { return hills(c + 7 * seed, r, 40); });
  const codec::TreeLayout layout = layout_of(dem, 16, 1.0 / 64);
  for (const codec::TileId id : {codec::TileId{0, 0, 0}, codec::TileId{1, 1, 0}, codec::TileId{1, 0, 1}}) {
    for (const int shift : {0, -1, -3}) {
      const codec::TileMesh mesh =
          random_tin(dem.grid, layout, id, shift, 3, static_cast<std::uint64_t>(seed * 100 - shift));
      ASSERT_TRUE(codec::validate(mesh, layout.cells_across(id.level)));
      expect_naive(dem, layout, id, mesh);
      const double anywhere = random_points(dem, layout, id, mesh, 200);
      const double exact = measure(*dem.source, audit::place(layout, id, mesh)).overall.value_m;
      EXPECT_LE(anywhere, exact + 1e-9);
      EXPECT_GT(anywhere, 0.5 * exact);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomTin, testing::Range(1, 5));

TEST(VerticalDistance, LeavesMissingNeighboursOfBordersAlone) {
  // Every kind of hole: single samples, pairs that touch at a point, a corner of the raster.
  const RasterFixture dem({.columns = 17, .rows = 17}, [](int c, int r) {
    const bool hole =
        (c == 5 && r == 5) || (c == 7 && r == 7) || (c < 3 && r < 2) || (c > 9 && c < 13 && r > 8 && r < 14);
    return hole ? kMissing : hills(c, r);
  });
  const TestTree tree = make_regular_tree(dem.path, {.tile_cells = 8, .z_step_m = 1});
  for (const cache::StoredTile& tile : tree.tiles) {
    expect_naive(dem, tree.manifest.layout, tile.info.id, tree.mesh(tile.info.id));
  }
}

/// The largest error lies on a sample of the window's far side, inside a mesh triangle.
TEST(VerticalDistance, OfAClosedWindowHasItsFarSides) {
  const RasterFixture dem({.columns = 9, .rows = 9}, [](int c, int r) { return c == 4 && r == 2 ? 50.0 : 0.0; });
  const codec::TreeLayout layout = layout_of(dem, 8, 1);
  const codec::TileMesh flat{0, 0, {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {8, 8, 0}}, {{0, 2, 3}, {0, 3, 1}}};
  const audit::TileSurface surface = audit::place(layout, {0, 0, 0}, flat);
  const audit::WindowBins bins(surface);
  audit::HeightWindow window;
  ASSERT_TRUE(window.read(*dem.source, surface.cells, {0, 0, 4, 4}));
  audit::WindowParts parts{bins.triangles(0), bins.edges(0), {}};
  EXPECT_EQ(audit::VerticalMeasure().measure(surface, window, parts).overall.value_m, 0);
  parts.closed = true;
  EXPECT_EQ(audit::VerticalMeasure().measure(surface, window, parts).overall.value_m, 50);
}

/// A tile of several windows gives what it gives in one piece.
TEST(VerticalDistance, IsTheSameAcrossWindows) {
  const int size = 2 * static_cast<int>(audit::kWindowCells) + 40;
  const RasterFixture dem({.columns = size, .rows = 600, .type = SampleType::kFloat32},
                          [](int c, int r) { return hills(c, r, 30); });
  codec::TreeLayout layout = layout_of(dem, 2048, 1.0 / 16);
  codec::TileMesh mesh;
  mesh.z_offset = -1000;
  // Long thin triangles that cross all windows at all angles.
  const std::int32_t w = size - 1;
  const std::int32_t h = 599;
  mesh.vertices = {{0, 0, 900},      {w, 0, 1100},    {w, h, 1000},   {0, h, 950},
                   {511, 300, 1200}, {513, 301, 800}, {700, 20, 1000}};
  mesh.triangles = {{0, 4, 6}, {0, 6, 1}, {6, 4, 5}, {6, 5, 1}, {1, 5, 2}, {5, 3, 2}, {4, 3, 5}, {0, 3, 4}};
  ASSERT_TRUE(codec::validate(mesh, 2048));
  const NaiveFigures naive = naive_figures(dem.grid, layout, {0, 0, 0}, mesh);
  const audit::TileSurface surface = audit::place(layout, {0, 0, 0}, mesh);
  ASSERT_EQ(audit::WindowBins(surface).count(), 6U);
  const audit::VerticalDistance d = measure(*dem.source, surface);
  EXPECT_NEAR(d.overall.value_m, naive.error_m, 1e-9);
  EXPECT_NEAR(d.border.value_m, naive.border_error_m, 1e-9);
  EXPECT_EQ(d.samples, static_cast<std::uint64_t>(size) * 600);
  EXPECT_NEAR(std::sqrt(d.sum_squares_m2 / static_cast<double>(d.samples)), naive.rms_m, 1e-9);
  EXPECT_EQ(coverage_faults(*dem.source, surface).count, 0U);
}

}  // namespace
}  // namespace tintree::test
