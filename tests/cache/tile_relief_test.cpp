#include "cache/tile_relief.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace tintree::cache {
namespace {

constexpr int kCells = 8;
constexpr int kSide = kCells + 2 * codec::kPatchMargin;

codec::TreeLayout layout_of(int leaf_level) {
  codec::TreeLayout layout;
  layout.tile_cells = kCells;
  layout.leaf_level = leaf_level;
  layout.columns = layout.rows = (std::int64_t{kCells} << leaf_level) + 1;
  layout.z_step_m.assign(static_cast<std::size_t>(leaf_level) + 1, 0.5);
  return layout;
}

codec::PatchResidual residual() { return *codec::make_patch_residual(codec::Patch(kSide, 3), codec::Patch(kSide, 0)); }

/// Cells of a 16 x 16 grid over the tile, each there by chance, two triangles each.
codec::TileMesh random_cells(std::mt19937& random, int xy_shift, double share) {
  codec::TileMesh mesh;
  mesh.xy_shift = xy_shift;
  std::bernoulli_distribution there(share);
  for (std::int32_t y = 0; y < 16; ++y) {
    for (std::int32_t x = 0; x < 16; ++x) {
      if (!there(random)) continue;
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.insert(mesh.vertices.end(), {{x, y, 0}, {x + 1, y, 0}, {x, y + 1, 0}, {x + 1, y + 1, 0}});
      mesh.triangles.push_back({first, first + 2, first + 3});
      mesh.triangles.push_back({first, first + 3, first + 1});
    }
  }
  return mesh;
}

TEST(TileRelief, SurfaceIsWhereTheMeshCoversASample) {
  std::mt19937 random(5);
  // Patch samples lie in the middles of 8 x 8 squares of a root three levels up: of 4 x 4 cells of these meshes' 16.
  const codec::TreeLayout layout = layout_of(3);
  for (int round = 0; round < 8; ++round) {
    const codec::TileMesh mesh = random_cells(random, 2, 0.1 + 0.1 * round);
    const TileRelief relief = make_tile_relief(layout, {0, 0, 0}, mesh, residual());
    ASSERT_EQ(relief.surface.size(), static_cast<std::size_t>(kSide * kSide));
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const auto place = [](int i) {
          return 8.0 * (std::clamp(i, codec::kPatchMargin, kSide - 1 - codec::kPatchMargin) - codec::kPatchMargin) +
                 3.5;
        };
        // In cells of the mesh, four samples each; no sample lies on a side.
        const bool own = x >= codec::kPatchMargin && y >= codec::kPatchMargin && x < kSide - codec::kPatchMargin &&
                         y < kSide - codec::kPatchMargin;
        const auto column = static_cast<std::int32_t>(place(x) / 4);
        const auto row = static_cast<std::int32_t>(place(y) / 4);
        const bool want = std::ranges::any_of(mesh.triangles, [&](const codec::Triangle& t) {
          return mesh.vertices[t[0]].x == column && mesh.vertices[t[0]].y == row;
        });
        EXPECT_EQ(relief.surface[static_cast<std::size_t>(y * kSide + x)] != 0, want) << x << " " << y << own;
      }
    }
  }
}

TEST(TileRelief, AWholeTileNeedsNoMask) {
  std::mt19937 random(5);
  EXPECT_TRUE(make_tile_relief(layout_of(3), {0, 0, 0}, random_cells(random, 2, 1), residual()).surface.empty());
}

TEST(TileRelief, KnowsItsPlaceInTheTree) {
  codec::TreeLayout layout = layout_of(2);
  layout.columns = 26;  // the last sample is column 25, of the second layer 6
  const codec::TileMesh mesh{0, 0, {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {8, 8, 0}}, {{0, 2, 3}, {0, 3, 1}}};
  const TileRelief root = make_tile_relief(layout, {0, 0, 0}, mesh, residual());
  EXPECT_FALSE(root.parent.has_value());
  EXPECT_TRUE(root.has_children);
  EXPECT_FLOAT_EQ(root.node_shift, 0.375F);
  EXPECT_EQ(root.on_raster, (std::array<int, 4>{2, 2, 8, 10}));
  const TileRelief leaf = make_tile_relief(layout, {2, 3, 2}, mesh, residual());
  EXPECT_EQ(leaf.parent, (codec::TileId{1, 1, 1}));
  EXPECT_FALSE(leaf.has_children);
  EXPECT_EQ(leaf.quadrant, 1);
  EXPECT_FLOAT_EQ(leaf.node_shift, 0);
  EXPECT_EQ(leaf.on_raster, (std::array<int, 4>{0, 0, 3, 11}));
  EXPECT_GE(leaf.bytes(), leaf.residual.bytes());
}

}  // namespace
}  // namespace tintree::cache
