#include "tests/bench/rivals/mesh_error.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <gtest/gtest.h>

namespace tintree::bench {
namespace {

HeightGrid rough_grid(int columns, int rows) {
  HeightGrid grid{columns, rows, 3, 5, {}};
  std::mt19937 random(4);
  std::uniform_real_distribution<double> height(-20, 20);
  for (int i = 0; i < columns * rows; ++i) grid.heights_m.push_back(height(random));
  return grid;
}

std::array<double, 3> at(const HeightGrid& grid, double column, double row, double z) {
  return {column * grid.dx_m, -row * grid.dy_m, z};
}

/// The whole grid as a fan around a hub at (column, row): four triangles.
TriangleMesh fan(const HeightGrid& grid, double column, double row, double z) {
  const int east = grid.columns - 1;
  const int south = grid.rows - 1;
  TriangleMesh mesh;
  mesh.vertices = {at(grid, 0, 0, 1), at(grid, 0, south, -2), at(grid, east, south, 3), at(grid, east, 0, 4),
                   at(grid, column, row, z)};
  mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return mesh;
}

/// The fan's height at a point, from barycentric weights.
double height_of(const HeightGrid& grid, const TriangleMesh& mesh, double column, double row) {
  const double x = column * grid.dx_m;
  const double y = -row * grid.dy_m;
  for (const auto& t : mesh.triangles) {
    const auto &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const auto cross = [](const auto& p, const auto& q, double u, double v) {
      return (q[0] - p[0]) * (v - p[1]) - (q[1] - p[1]) * (u - p[0]);
    };
    const double area = cross(a, b, c[0], c[1]);
    const double wa = cross(b, c, x, y) / area;
    const double wb = cross(c, a, x, y) / area;
    if (std::min({wa, wb, 1 - wa - wb}) > -1e-12) return wa * a[2] + wb * b[2] + (1 - wa - wb) * c[2];
  }
  return std::nan("");
}

TEST(MeshError, IsNoneForTheSurfaceItself) {
  const HeightGrid grid = rough_grid(13, 9);
  const MeshError error = measure(grid, full_mesh(grid));
  EXPECT_LT(error.samples_max_m, 1e-12);
  EXPECT_LT(error.surface_max_m, 1e-12);
  EXPECT_LT(error.rms_m, 1e-12);
  EXPECT_EQ(error.uncovered, 0U);
  EXPECT_EQ(error.folded, 0U);
}

TEST(MeshError, MatchesBruteForceOverSamplesAndSurface) {
  const HeightGrid grid = rough_grid(13, 9);
  const TriangleMesh mesh = fan(grid, 5.25, 3.75, 30);
  const MeshError error = measure(grid, mesh);

  double samples = 0;
  double squares = 0;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const double d = std::abs(height_of(grid, mesh, column, row) - grid.at(column, row));
      samples = std::max(samples, d);
      squares += d * d;
    }
  }
  EXPECT_NEAR(error.samples_max_m, samples, 1e-9);
  EXPECT_NEAR(error.rms_m, std::sqrt(squares / static_cast<double>(grid.heights_m.size())), 1e-9);

  double dense = 0;
  constexpr int kFine = 60;
  for (int i = 0; i <= (grid.columns - 1) * kFine; ++i) {
    for (int j = 0; j <= (grid.rows - 1) * kFine; ++j) {
      const double column = static_cast<double>(i) / kFine;
      const double row = static_cast<double>(j) / kFine;
      dense = std::max(dense, std::abs(height_of(grid, mesh, column, row) - grid.surface(column, row)));
    }
  }
  EXPECT_GE(error.surface_max_m, dense - 1e-9);
  EXPECT_LE(error.surface_max_m, dense + 1.5) << "no more than the fine raster can have missed";
}

TEST(MeshError, SeesWhatLiesBetweenTheSamples) {
  HeightGrid grid{2, 2, 1, 1, {0, 0, 0, 0}};
  grid.heights_m = {0, 10, 10, 0};  // a valley along the surface's diagonal
  TriangleMesh other;               // the same samples joined by the other diagonal: a ridge
  other.vertices = {at(grid, 0, 0, 0), at(grid, 0, 1, 10), at(grid, 1, 1, 0), at(grid, 1, 0, 10)};
  other.triangles = {{0, 1, 3}, {1, 2, 3}};
  const MeshError error = measure(grid, other);
  EXPECT_LT(error.samples_max_m, 1e-12);
  EXPECT_DOUBLE_EQ(error.surface_max_m, 10);
}

TEST(MeshError, CountsUncoveredSamplesAndFoldedTriangles) {
  const HeightGrid grid = rough_grid(13, 9);
  TriangleMesh mesh = fan(grid, 5, 3, 0);
  std::swap(mesh.triangles[1][0], mesh.triangles[1][1]);
  EXPECT_EQ(measure(grid, mesh).folded, 1U);
  mesh.triangles = {{0, 1, 4}};
  const MeshError error = measure(grid, mesh);
  EXPECT_GT(error.uncovered, 0U);
  EXPECT_LT(error.uncovered, grid.heights_m.size());
}

/// A grid of rough heights where one sample is missing, one stands alone, and a corner has lost a triangle.
HeightGrid holed_grid() {
  HeightGrid grid = rough_grid(9, 8);
  const auto lose = [&](int column, int row) {
    grid.heights_m[static_cast<std::size_t>(row * 9 + column)] = std::nan("");
  };
  lose(4, 4);
  lose(0, 0);
  for (const auto& [column, row] : {std::pair{6, 6}, {7, 6}, {8, 6}, {7, 7}, {6, 7}})
    lose(column, row);  // (8, 7) is alone
  return grid;
}

TEST(MeshError, IsNoneForASurfaceWithHoles) {
  const HeightGrid grid = holed_grid();
  const MeshError error = measure(grid, full_mesh(grid));
  EXPECT_LT(error.samples_max_m, 1e-12);
  EXPECT_LT(error.surface_max_m, 1e-12);
  EXPECT_EQ(error.uncovered, 0U);
  EXPECT_EQ(error.filled, 0U);
}

TEST(MeshError, CountsWhatIsCoveredBeyondTheSurface) {
  const HeightGrid grid = holed_grid();
  const TriangleMesh mesh = fan(grid, 5.25, 3.75, 30);
  const MeshError error = measure(grid, mesh);
  EXPECT_EQ(error.uncovered, 0U);
  EXPECT_EQ(error.filled, 8U);  // seven missing, and the one that stands alone

  // The same heights without holes: errors within the surface are the same, those in the holes were not counted.
  const MeshError whole = measure(rough_grid(9, 8), mesh);
  double worst = 0;
  for (std::size_t i = 0; i < grid.heights_m.size(); ++i) {
    EXPECT_LE(error.map_m[i] > 0 ? error.map_m[i] : 0, whole.map_m[i]) << i;
    if (error.map_m[i] > worst) worst = error.map_m[i];
  }
  EXPECT_NEAR(worst, error.surface_max_m, 1e-5);
}

TEST(MeshError, CountsWhatIsNotCovered) {
  const HeightGrid grid = holed_grid();
  TriangleMesh mesh = full_mesh(grid);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    return std::ranges::any_of(t, [&](std::uint32_t v) { return mesh.vertices[v][0] > 7.5 * grid.dx_m; });
  });
  EXPECT_EQ(measure(grid, mesh).uncovered, 6U);  // the last column down to the hole
}

}  // namespace
}  // namespace tintree::bench
