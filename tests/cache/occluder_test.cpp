#include "cache/occluder.h"

#include <cmath>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "tests/render/analytic_tree.h"

namespace tintree::cache {
namespace {

/// The surface's height at a place of the grid, by looking at every triangle.
std::optional<double> height_m(const codec::GridFrame& frame, const codec::TileMesh& mesh, double column, double row) {
  for (const codec::Triangle& t : mesh.triangles) {
    std::array<std::array<double, 3>, 3> p{};
    for (std::size_t i = 0; i < 3; ++i) {
      const codec::GridVertex& v = mesh.vertices[t[i]];
      p[i] = {frame.column(v.x) - column, frame.row(v.y) - row, frame.height_m(v.z)};
    }
    const auto area = [&](std::size_t a, std::size_t b) { return p[a][0] * p[b][1] - p[b][0] * p[a][1]; };
    const std::array<double, 3> w{area(1, 2), area(2, 0), area(0, 1)};
    const double all = w[0] + w[1] + w[2];
    if (w[0] / all < -1e-9 || w[1] / all < -1e-9 || w[2] / all < -1e-9) continue;
    return (w[0] * p[0][2] + w[1] * p[1][2] + w[2] * p[2][2]) / all;
  }
  return std::nullopt;
}

/// A tree over a raster of odd size, so that some tiles are cut short.
test::AnalyticTree rough_tree() {
  test::AnalyticTree tree;
  tree.columns = 150;
  tree.rows = 101;
  tree.tile_cells = 64;
  tree.height_m = [](double x, double y) { return 90 * std::sin(x / 60) * std::cos(y / 45) + 30 * std::sin(x * y); };
  return tree;
}

TEST(Occluder, ItsLinesLieUnderTheSurfaceAndItsPlanesAbove) {
  const test::AnalyticTree tree = rough_tree();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> in(0, 1);
  for (const codec::TileId& id : tree.tiles()) {
    const codec::TileMesh mesh = tree.mesh(id);
    const codec::GridFrame frame(tree.layout(), id, mesh);
    const Occluder o = make_occluder(tree.layout(), id, mesh);
    ASSERT_TRUE(o.closed) << id.text();
    const auto wide = static_cast<double>(o.cells.column1 - o.cells.column0);
    const auto high = static_cast<double>(o.cells.row1 - o.cells.row0);
    for (int i = 0; i < 300; ++i) {
      const std::size_t line = random() % Occluder::kLines;
      const double at = in(random) * static_cast<double>(Occluder::kStrips);
      const auto node = std::min(static_cast<std::size_t>(at), Occluder::kStrips - 1);
      const bool row = i % 2 == 0;
      const Occluder::Line& heights = row ? o.row_lines[line] : o.column_lines[line];
      const double share = at - static_cast<double>(node);
      const double bound =
          (1 - share) * static_cast<double>(heights[node]) + share * static_cast<double>(heights[node + 1]);
      const double u = row ? at : static_cast<double>(line);
      const double v = row ? static_cast<double>(line) : at;
      const double column = static_cast<double>(o.cells.column0) + u * wide / Occluder::kStrips;
      const double line_row = static_cast<double>(o.cells.row0) + v * high / Occluder::kStrips;
      const auto z = height_m(frame, mesh, column, line_row);
      ASSERT_TRUE(z);
      EXPECT_LE(bound, *z + 1e-6) << id.text() << " " << column << " " << line_row;
      const double c = static_cast<double>(o.cells.column0) + in(random)*wide;
      const double r = static_cast<double>(o.cells.row0) + in(random)*high;
      EXPECT_GE(o.top_m(c, r), *height_m(frame, mesh, c, r) - 1e-6) << id.text();
    }
  }
}

TEST(Occluder, IsTightOnAPlane) {
  test::AnalyticTree tree;
  tree.height_m = [](double x, double y) { return 0.25 * x - 0.5 * y; };
  const codec::TileId id{2, 1, 2};
  const Occluder o = make_occluder(tree.layout(), id, tree.mesh(id));
  for (std::size_t line = 0; line < Occluder::kLines; ++line) {
    for (std::size_t i = 0; i < Occluder::kLines; ++i) {
      const auto z = [&](std::size_t column, std::size_t row) {
        return 0.25 * 10 * (32 + 2 * static_cast<double>(column)) + 0.5 * 10 * (64 + 2 * static_cast<double>(row));
      };
      EXPECT_NEAR(static_cast<double>(o.row_lines[line][i]), z(i, line), 1e-3);
      EXPECT_NEAR(static_cast<double>(o.column_lines[line][i]), z(line, i), 1e-3);
    }
  }
  EXPECT_NEAR(o.top_m(40.3, 70.9), 0.25 * 403 + 0.5 * 709, 1e-3);
}

TEST(Occluder, OneMissingTriangleIsAHole) {
  const test::AnalyticTree tree;
  const codec::TileId id{1, 0, 1};
  codec::TileMesh mesh = tree.mesh(id);
  EXPECT_TRUE(make_occluder(tree.layout(), id, mesh).closed);
  mesh.triangles.pop_back();
  const Occluder o = make_occluder(tree.layout(), id, mesh);
  EXPECT_FALSE(o.closed);
  EXPECT_EQ(o.bytes(), 0U);
  EXPECT_EQ(o.top_m(10, 70), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace tintree::cache
