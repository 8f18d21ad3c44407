/// The fast measure against the brute-force overlay.

#include "simplify/error_meter.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "simplify/tin_maker.h"
#include "tests/simplify/support.h"
#include "tests/support/adversarial_terrain.h"

namespace tintree::simplify {
namespace {

using codec::CellRect;
using codec::TileId;
using test::Terrain;

std::vector<std::uint32_t> all_of(const MeasuredMesh& mesh) {
  std::vector<std::uint32_t> which(mesh.triangles.size());
  std::iota(which.begin(), which.end(), 0U);
  return which;
}

MeasuredError measured(const Terrain& terrain, const MeasuredMesh& mesh, const std::vector<CellRect>& windows) {
  SurfaceView view(*terrain.surface);
  ErrorMeter meter(view);
  MeasuredError sum;
  for (const CellRect& window : windows) {
    meter.set_window(window);
    sum += meter.measure(mesh, all_of(mesh));
  }
  return sum;
}

/// The rectangle cut into `parts` x `parts` windows.
std::vector<CellRect> split(const CellRect& cells, std::int64_t parts) {
  std::vector<CellRect> out;
  const std::int64_t width = (cells.column1 - cells.column0 + parts - 1) / parts;
  const std::int64_t height = (cells.row1 - cells.row0 + parts - 1) / parts;
  for (std::int64_t r = cells.row0; r < cells.row1; r += height) {
    for (std::int64_t c = cells.column0; c < cells.column1; c += width) {
      out.push_back({c, r, std::min(c + width, cells.column1), std::min(r + height, cells.row1)});
    }
  }
  return out;
}

void expect_same(const MeasuredError& found, const test::Overlay& expected) {
  EXPECT_NEAR(found.max_m, expected.max_m, 1e-8 * (1 + expected.max_m));
  EXPECT_NEAR(found.border_max_m, expected.border_max_m, 1e-8 * (1 + expected.max_m));
  EXPECT_EQ(found.samples, expected.samples);
  EXPECT_NEAR(found.rms_m(), expected.rms_m, 1e-8 * (1 + expected.rms_m));
}

/// Tiles as the maker leaves them, and with every vertex moved in height at random.
void compare_tree(const Terrain& terrain, int tile_cells, double error_m) {
  const codec::TreeLayout layout = test::make_layout(terrain, tile_cells, error_m);
  TinMaker maker(*terrain.surface, layout);
  std::mt19937 random(5);
  for (const TileId& id : test::tiles_of(layout)) {
    SCOPED_TRACE(id.text());
    auto mesh = maker.make(id);
    ASSERT_TRUE(mesh.has_value());
    for (int round = 0; round < 2; ++round) {
      const test::Overlay expected = test::overlay(terrain.grid, layout, id, *mesh);
      const MeasuredMesh measurable(layout, id, *mesh);
      for (const std::int64_t parts : {1, 2, 3}) {
        expect_same(measured(terrain, measurable, split(measurable.cells, parts)), expected);
      }
      for (codec::GridVertex& v : mesh->vertices) v.z += static_cast<std::int32_t>(random() % 41);
    }
  }
}

class ErrorMeterTest : public testing::TestWithParam<test::AdversarialTerrain> {};

TEST_P(ErrorMeterTest, EqualsTheOverlay) {
  const Terrain terrain = test::make_terrain(GetParam().columns, GetParam().rows, GetParam().height);
  compare_tree(terrain, 32, 1.5);
}

INSTANTIATE_TEST_SUITE_P(Shapes, ErrorMeterTest, testing::ValuesIn(test::everyday_terrains()),
                         [](const auto& shape) { return shape.param.name; });

TEST(ErrorMeter, MeasuresVerticesBetweenSamples) {
  // One vertex at a quarter of a sample, joined to the four corners of the square.
  const Terrain terrain = test::make_terrain(9, 9, test::rough_hills(10, 3, 0));
  codec::TreeLayout layout = test::make_layout(terrain, 8, 10);
  for (std::int32_t place = 1; place < 32; place += 3) {
    codec::TileMesh mesh;
    mesh.xy_shift = -2;
    mesh.vertices = {{0, 0, 0}, {32, 0, 3}, {32, 32, 1}, {0, 32, 2}, {place, 33 - place, 4}};
    mesh.triangles = {{1, 0, 4}, {2, 1, 4}, {3, 2, 4}, {0, 3, 4}};
    const MeasuredMesh measurable(layout, {}, mesh);
    const test::Overlay expected = test::overlay(terrain.grid, layout, {}, mesh);
    EXPECT_LE(expected.coverage_error, 1e-12);
    for (const std::int64_t parts : {1, 2, 4})
      expect_same(measured(terrain, measurable, split(measurable.cells, parts)), expected);
  }
}

TEST(ErrorMeter, TellsASideFromAnEdgeAcross) {
  // Two rectangles that meet on row 4, from the west side to the east; only there is the mesh off.
  const Terrain terrain = test::make_terrain(9, 9, [](int c, int r) { return r == 4 && c > 0 && c < 8 ? 7.0 : 0.0; });
  const codec::TreeLayout layout = test::make_layout(terrain, 8, 10);
  codec::TileMesh mesh;
  mesh.xy_shift = 2;
  mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 1, 0}, {0, 2, 0}, {2, 2, 0}};
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}};
  const MeasuredMesh measurable(layout, {}, mesh);
  const MeasuredError found = measured(terrain, measurable, {measurable.cells});
  EXPECT_EQ(found.max_m, 7);
  EXPECT_EQ(found.border_max_m, 0);
}

TEST(ErrorMeter, FindsNothingOnAPlane) {
  const Terrain terrain = test::make_terrain(65, 65, [](int c, int r) { return 2.0 * c - r; });
  const codec::TreeLayout layout = test::make_layout(terrain, 64, 1);
  auto mesh = TinMaker(*terrain.surface, layout).make({});
  ASSERT_TRUE(mesh.has_value());
  const MeasuredMesh measurable(layout, {}, *mesh);
  const MeasuredError found = measured(terrain, measurable, {measurable.cells});
  EXPECT_NEAR(found.max_m, 0, 1e-9);
  EXPECT_EQ(found.samples, 65U * 65);
  EXPECT_NEAR(found.rms_m(), 0, 1e-9);
}

TEST(MeasuredError, PartsAddUp) {
  MeasuredError sum{1, 0.5, 4, 2};
  sum += {3, 0.25, 5, 7};
  EXPECT_EQ(sum.max_m, 3);
  EXPECT_EQ(sum.border_max_m, 0.5);
  EXPECT_EQ(sum.rms_m(), 1);
  EXPECT_EQ(MeasuredError{}.rms_m(), 0);
}

}  // namespace
}  // namespace tintree::simplify
