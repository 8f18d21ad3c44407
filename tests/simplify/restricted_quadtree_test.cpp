/// Restricted quadtree meshes against brute force: within the bound, equal borders, nested.

#include "simplify/restricted_quadtree.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"
#include "tests/support/adversarial_terrain.h"

namespace tintree::simplify {
namespace {

using test::AdversarialTerrain;
using test::Terrain;

/// The trees of a whole layout's tiles, and their meshes.
class Quadtrees {
 public:
  Quadtrees(const Terrain& terrain, int tile_cells, double error_m)
      : terrain_(terrain), layout_(test::make_layout(terrain, tile_cells, error_m)), view_(*terrain.surface) {}

  const codec::TreeLayout& layout() const { return layout_; }

  LevelGrid level(int l) const {
    return {layout_.cells_across(l), layout_.bound_m(l), {layout_.z_step_m[static_cast<std::size_t>(l)]}};
  }

  RestrictedQuadtree tree(const codec::TileId& id, double bound_m) {
    LevelGrid grid = level(id.level);
    grid.bound_m = bound_m;
    return {view_, grid, id.x * grid.cells, id.y * grid.cells};
  }
  std::vector<RestrictedQuadtree> nested(const codec::TileId& id, int count) {
    const LevelGrid grid = level(id.level);
    return RestrictedQuadtree::nested(view_, grid, count, id.x * grid.cells, id.y * grid.cells);
  }
  RestrictedQuadtree tree(const codec::TileId& id) { return tree(id, layout_.bound_m(id.level)); }

  codec::TileMesh mesh(const RestrictedQuadtree& tree, const codec::TileId& id) {
    const LevelGrid grid = level(id.level);
    auto mesh = quadtree_tile(tree, view_, grid.heights, 1, id.x * grid.cells, id.y * grid.cells, id);
    EXPECT_TRUE(mesh.has_value());
    return std::move(*mesh);
  }

  void expect_sound(const codec::TileId& id, const codec::TileMesh& mesh, double bound_m) const {
    if (test::half_cells(terrain_.grid, layout_.cells(id)) == 0) {
      EXPECT_TRUE(mesh.triangles.empty());
      return;
    }
    test::expect_sound_mesh(terrain_.grid, layout_, id, mesh);
    const test::Overlay found = test::overlay(terrain_.grid, layout_, id, mesh);
    EXPECT_LE(found.coverage_error, 1e-9);
    EXPECT_LE(found.max_m, bound_m * (1 + 1e-12));
    EXPECT_LE(found.border_max_m, bound_m / 2 * (1 + 1e-12));
  }

  /// Where the mesh has vertices on one side of its square, and how high.
  using Border = std::set<std::tuple<double, double, double>>;
  Border border(const codec::TileId& id, const codec::TileMesh& mesh, bool southward, std::int64_t at) const {
    const codec::GridFrame frame(layout_, id, mesh);
    Border out;
    for (const codec::GridVertex& v : mesh.vertices) {
      const double column = frame.column(v.x);
      const double row = frame.row(v.y);
      if ((southward ? column : row) == static_cast<double>(at)) out.insert({column, row, frame.height_m(v.z)});
    }
    return out;
  }

 private:
  const Terrain& terrain_;
  codec::TreeLayout layout_;
  SurfaceView view_;
};

void expect_sound_tree(const Terrain& terrain, int tile_cells, double error_m) {
  SCOPED_TRACE("tile " + std::to_string(tile_cells) + " error " + std::to_string(error_m));
  Quadtrees trees(terrain, tile_cells, error_m);
  for (const codec::TileId& id : test::tiles_of(trees.layout())) {
    SCOPED_TRACE(id.text());
    const codec::TileMesh mesh = trees.mesh(trees.tree(id), id);
    trees.expect_sound(id, mesh, trees.layout().bound_m(id.level));
    const std::int64_t cells = trees.layout().cells_across(id.level);
    for (const bool southward : {false, true}) {
      const codec::TileId next{id.level, id.x + (southward ? 1 : 0), id.y + (southward ? 0 : 1)};
      const std::int64_t at = (southward ? id.x + 1 : id.y + 1) * cells;
      if (next.x >= trees.layout().tiles_x(id.level) || next.y >= trees.layout().tiles_y(id.level)) continue;
      // A vertex next to which one of the tiles has no surface is not in both.
      if (!std::ranges::all_of(terrain.grid.heights_m, [](double h) { return h == h; })) continue;
      EXPECT_EQ(trees.border(id, mesh, southward, at),
                trees.border(next, trees.mesh(trees.tree(next), next), southward, at));
    }
    if (testing::Test::HasFailure()) return;
  }
}

class RestrictedQuadtreeTest : public testing::TestWithParam<AdversarialTerrain> {};

TEST_P(RestrictedQuadtreeTest, IsSoundAtEveryBound) {
  const Terrain terrain = test::make_terrain(GetParam().columns, GetParam().rows, GetParam().height);
  for (const auto& [tile_cells, error_m] : {std::pair{8, 20.0}, {64, 0.05}, {64, 3.0}, {256, 100.0}}) {
    expect_sound_tree(terrain, tile_cells, error_m);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, RestrictedQuadtreeTest, testing::ValuesIn(test::everyday_terrains()),
                         [](const auto& shape) { return shape.param.name; });

TEST(RestrictedQuadtree, IsSoundOnRandomTerrain) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const double holes = seed % 2 == 0 ? 0 : 0.002 * seed;
    expect_sound_tree(test::make_terrain(150, 131, test::rough_hills(30, 1, holes, seed)), 32, 0.5 * (1 << seed % 4));
  }
}

TEST(RestrictedQuadtree, MergesTheSquaresOfAPlane) {
  // The sides keep 16 segments each; the rest is what these ask for.
  const Terrain terrain = test::make_terrain(257, 257, [](int c, int r) { return 0.25 * c - 0.5 * r; });
  Quadtrees trees(terrain, 256, 1);
  const codec::TileMesh mesh = trees.mesh(trees.tree({0, 0, 0}), {0, 0, 0});
  trees.expect_sound({0, 0, 0}, mesh, 1);
  // Round the border, from 64 segments: 64 + 2 * 60 triangles in the outer ring, and so on inward.
  EXPECT_LT(mesh.triangles.size(), 400U);
  EXPECT_GT(mesh.triangles.size(), 64U);
}

/// Nested meshes are those that are found for each bound alone.
void expect_nested(const Terrain& terrain, int tile_cells, double error_m, int count) {
  Quadtrees trees(terrain, tile_cells, error_m);
  for (const codec::TileId& id : test::tiles_of(trees.layout())) {
    SCOPED_TRACE(id.text());
    const double finest_m = trees.layout().bound_m(id.level);
    const std::vector<RestrictedQuadtree> nested = trees.nested(id, count);
    ASSERT_EQ(nested.size(), static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      SCOPED_TRACE(i);
      const RestrictedQuadtree& tree = nested[static_cast<std::size_t>(i)];
      const double bound_m = std::ldexp(finest_m, count - 1 - i);
      trees.expect_sound(id, trees.mesh(tree, id), bound_m);
      const RestrictedQuadtree alone = trees.tree(id, bound_m);
      EXPECT_EQ(tree.vertices(), alone.vertices());
      tree.for_each_vertex([&](const codec::SplitPoint& p) {
        EXPECT_TRUE(alone.get(p)) << p.x << ' ' << p.y;
        EXPECT_TRUE(i == count - 1 || nested[static_cast<std::size_t>(i) + 1].get(p)) << p.x << ' ' << p.y;
      });
    }
    EXPECT_GE(nested.back().vertices(), nested.front().vertices());
    if (testing::Test::HasFailure()) return;
  }
}

TEST(RestrictedQuadtree, NestsCoarseMeshesInFineOnes) {
  expect_nested(test::make_terrain(300, 200, test::rough_hills(30, 1, 0.0005, 7)), 128, 0.5, 5);
  expect_nested(test::make_terrain(90, 70, test::rough_hills(30, 1, 0.02, 8)), 32, 0.25, 9);
  expect_nested(test::make_terrain(100, 140, test::rough_hills(30, 0.1, 0, 9)), 16, 0.1, 9);
}

TEST(RestrictedQuadtree, GivesEveryTriangleItsRightAngle) {
  const Terrain terrain = test::make_terrain(129, 129, test::rough_hills(30, 1, 0, 3));
  Quadtrees trees(terrain, 128, 1);
  std::int64_t area = 0;
  trees.tree({0, 0, 0}).for_each_triangle([&](const auto& a, const auto& b, const auto& c) {
    EXPECT_EQ((a.x - c.x) * (b.x - c.x) + (a.y - c.y) * (b.y - c.y), 0);
    const std::int64_t doubled = (c.x - a.x) * (b.y - a.y) - (b.x - a.x) * (c.y - a.y);
    EXPECT_GT(doubled, 0);
    area += doubled;
  });
  EXPECT_EQ(area, 2 * 256 * 256);
}

}  // namespace
}  // namespace tintree::simplify
