/// What every tile of method scalar promises, on the stored bytes, over rasters made to break it.

#include "simplify/scalar_maker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "codec/mesh_codec.h"
#include "tests/simplify/support.h"
#include "tests/simplify/whole_tree.h"
#include "tests/support/adversarial_terrain.h"
#include "tests/support/temp_dir.h"

namespace tintree::simplify {
namespace {

using codec::QuantizerKind;
using codec::TileId;
using test::AdversarialTerrain;
using test::Terrain;

void expect_sound(const Terrain& terrain, int tile_cells, double wished_m, const std::string& quantizer) {
  const double error_m = test::accepted_error_m(terrain, tile_cells, wished_m);
  SCOPED_TRACE(testing::Message() << quantizer << ", tile " << tile_cells << ", error " << error_m << " m");
  const test::TempDir dir;
  const auto tree = test::build_whole_tree(terrain, test::make_layout(terrain, tile_cells, error_m),
                                           dir.file("t.tintree"), "fast", "scalar", quantizer);
  ASSERT_TRUE(tree.has_value()) << tree.error().text();
  test::expect_sound_tree(terrain, *tree);
}

class ScalarMakerTest : public testing::TestWithParam<AdversarialTerrain> {};

TEST_P(ScalarMakerTest, KeepsItsPromises) {
  const test::TempDir dir;
  test::write_terrain(dir.file("dem.tif"), GetParam());
  const Terrain terrain = test::read_terrain(dir.file("dem.tif"));
  if (!terrain.surface->has_surface()) return;
  const auto range = terrain.surface->height_range_m({0, 0, GetParam().columns - 1, GetParam().rows - 1});
  const double relief_m = std::max(range[1] - range[0], 1e-3);
  expect_sound(terrain, 16, relief_m / 200, "uniform");
  expect_sound(terrain, 32, relief_m / 6, "lloyd-max");
}

INSTANTIATE_TEST_SUITE_P(Terrains, ScalarMakerTest, testing::ValuesIn(test::adversarial_terrains()),
                         [](const auto& shape) { return shape.param.name; });

TEST(ScalarMaker, KeepsItsPromisesOnRandomTerrain) {
  for (unsigned seed = 1; seed < 25 && !testing::Test::HasFailure(); ++seed) {
    const AdversarialTerrain shape = test::random_terrain(seed);
    SCOPED_TRACE("make_terrain random_" + std::to_string(seed));
    const Terrain terrain = test::make_exact_terrain(shape.columns, shape.rows, shape.height);
    if (!terrain.surface->has_surface()) continue;
    const auto range = terrain.surface->height_range_m({0, 0, shape.columns - 1, shape.rows - 1});
    expect_sound(terrain, 8 << (seed % 3), std::max(1e-6, std::pow(0.3, seed % 7) * (range[1] - range[0])),
                 seed % 2 == 0 ? "uniform" : "lloyd-max");
  }
}

TEST(ScalarMaker, SmoothGroundTakesAWideGrid) {
  const Terrain hills = test::make_terrain(257, 257, [](int c, int r) { return test::hills(c, r, 40); });
  const codec::TreeLayout layout = test::make_layout(hills, 256, 8);
  ScalarMaker maker(*hills.surface, layout, QuantizerKind::kUniform);
  const auto mesh = maker.make({0, 0, 0});
  ASSERT_TRUE(mesh.has_value());
  EXPECT_LT(mesh->triangles.size(), 2U * 256 * 256 / 12);
  // A plane's grid is as wide as it gets: a vertex inside, and one in each quarter, which has others on the sides.
  const Terrain plane = test::make_terrain(257, 257, [](int c, int r) { return 3.0 * c - r; });
  const auto flat =
      ScalarMaker(*plane.surface, test::make_layout(plane, 256, 8), QuantizerKind::kUniform).make({0, 0, 0});
  ASSERT_TRUE(flat.has_value());
  EXPECT_EQ(flat->vertices.size(), 32U + 5U);
}

/// Heights of the inner grid: how many levels there are.
std::size_t level_count(const codec::TileMesh& mesh) {
  const auto found = codec::find_scalar_tile(mesh);
  EXPECT_TRUE(found.has_value());
  std::set<std::int32_t> heights;
  for (std::size_t i = found->grid.border_count; i < found->tile.z.size(); ++i) heights.insert(found->tile.z[i]);
  return heights.size();
}

TEST(ScalarMaker, TheBoundChoosesTheLevels) {
  const Terrain noise = test::make_terrain(65, 65, [](int c, int r) { return 100 * test::noise(c, r); });
  std::size_t last = 1000;
  for (const double error_m : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    const codec::TreeLayout layout = test::make_layout(noise, 64, error_m);
    const auto mesh = ScalarMaker(*noise.surface, layout, QuantizerKind::kUniform).make({0, 0, 0});
    ASSERT_TRUE(mesh.has_value());
    const std::size_t levels = level_count(*mesh);
    // Levels are seven quarters of the bound apart.
    EXPECT_NEAR(static_cast<double>(levels), 100 / (1.75 * error_m), 2) << error_m;
    EXPECT_LT(levels, last);
    last = levels;
  }
}

/// On dense ground a Lloyd-Max quantiser's levels move heights as far as a uniform one's, and no farther.
TEST(ScalarMaker, LloydMaxUsesTheBound) {
  const Terrain noise = test::make_terrain(65, 65, [](int c, int r) { return 100 * std::pow(test::noise(c, r), 3); });
  const codec::TreeLayout layout = test::make_layout(noise, 64, 2);
  SurfaceView samples(*noise.surface);
  std::array<double, 2> off{};
  for (const QuantizerKind kind : {QuantizerKind::kUniform, QuantizerKind::kLloydMax}) {
    const auto mesh = ScalarMaker(*noise.surface, layout, kind).make({0, 0, 0});
    ASSERT_TRUE(mesh.has_value());
    const auto tile = codec::find_scalar_tile(*mesh);
    ASSERT_TRUE(tile.has_value());
    std::size_t inside = 0;
    double& most = off[kind == QuantizerKind::kLloydMax ? 1 : 0];
    for (std::size_t i = tile->grid.border_count; i < tile->grid.places.size(); ++i, ++inside) {
      const codec::GridVertex& at = tile->grid.places[i];
      const double height_m = static_cast<double>(mesh->z_offset + tile->tile.z[i]) * layout.z_step_m[0];
      const double sample_m = samples.sample(at.x, at.y);
      most = std::max(most, std::abs(height_m - sample_m));
    }
    ASSERT_EQ(mesh->xy_shift, 0);
    EXPECT_EQ(inside, 63U * 63) << "every sample has its vertex";
  }
  EXPECT_LE(off[1], 2 * 7 / 8.0);
  EXPECT_GT(off[1], 0.9 * off[0]);
}

TEST(ScalarMaker, TwoHeightsTakeTwoLevels) {
  const Terrain steps =
      test::make_terrain(65, 65, [](int c, int r) { return test::noise(c, r) < 0.5 ? -7.0 : 5000.0; });
  for (const QuantizerKind kind : {QuantizerKind::kUniform, QuantizerKind::kLloydMax}) {
    const codec::TreeLayout layout = test::make_layout(steps, 64, 1);
    const auto mesh = ScalarMaker(*steps.surface, layout, kind).make({0, 0, 0});
    ASSERT_TRUE(mesh.has_value());
    EXPECT_EQ(level_count(*mesh), 2U);
    EXPECT_LT(codec::find_codec("scalar")->encode(*mesh)->size(), 63U * 63 / 8 + 256 * 3 + 100);
  }
}

TEST(ScalarMaker, TilesDoNotDependOnTheirOrder) {
  const Terrain rough = test::make_terrain(150, 131, test::rough_hills(30, 2, 0.0005, 5));
  const codec::TreeLayout layout = test::make_layout(rough, 32, 1);
  const codec::MeshCodec& codec = *codec::find_codec("scalar");
  std::vector<TileId> ids = test::tiles_of(layout);
  ScalarMaker forward(*rough.surface, layout, QuantizerKind::kUniform);
  std::vector<std::vector<std::byte>> first;
  for (const TileId& id : ids) first.push_back(*codec.encode(*forward.make(id)));
  ScalarMaker backward(*rough.surface, layout, QuantizerKind::kUniform);
  for (std::size_t i = ids.size(); i-- > 0;)
    EXPECT_EQ(*codec.encode(*backward.make(ids[i])), first[i]) << ids[i].text();
}

TEST(ScalarMaker, EndsSoonAfterAStop) {
  const Terrain rough = test::make_terrain(150, 131, test::rough_hills(30, 2, 0, 5));
  const StopFlag stop = true;
  ScalarMaker maker(*rough.surface, test::make_layout(rough, 32, 1), QuantizerKind::kUniform, &stop);
  const auto mesh = maker.make({0, 0, 0});
  ASSERT_FALSE(mesh.has_value());
  EXPECT_EQ(mesh.error().code, ErrorCode::kStopped);
}

/// Ground is rough, or samples are missing, in one place of a plane: only there are vertices close.
TEST(ScalarMaker, WhatIsRoughInOnePlaceCostsLittle) {
  for (const double odd : {test::kMissing, 500.0}) {
    const Terrain plane =
        test::make_terrain(1025, 1025, [&](int c, int r) { return c == 300 && r == 700 ? odd : 1.0; });
    const codec::TreeLayout layout = test::make_layout(plane, 1024, 1);
    const auto mesh = ScalarMaker(*plane.surface, layout, QuantizerKind::kUniform).make({0, 0, 0});
    ASSERT_TRUE(mesh.has_value());
    // Nine strides, each of a ring of blocks of 4 x 4.
    EXPECT_LT(mesh->vertices.size(), 9U * 16 * 16);
  }
}

/// A circle of 400 samples across in nothing: what is empty costs nothing, and its outline what it is long.
TEST(ScalarMaker, AHoleCostsItsOutline) {
  for (const bool inside : {false, true}) {
    const Terrain disk = test::make_terrain(1025, 1025, [&](int c, int r) {
      return (std::hypot(c - 512, r - 512) < 200) == inside ? 1.0 : test::kMissing;
    });
    const codec::TreeLayout layout = test::make_layout(disk, 1024, 1);
    const auto mesh = ScalarMaker(*disk.surface, layout, QuantizerKind::kUniform).make({0, 0, 0});
    ASSERT_TRUE(mesh.has_value());
    EXPECT_LT(mesh->vertices.size(), 1260U * 20);
    EXPECT_LT(codec::find_codec("scalar")->encode(*mesh)->size(), 1260U * 16);
  }
}

}  // namespace
}  // namespace tintree::simplify
