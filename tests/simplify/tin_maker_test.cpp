/// What every tile promises, over rasters made to break it.

#include "simplify/tin_maker.h"

#include <cmath>

#include <gtest/gtest.h>

#include "codec/coded_tin_mesh.h"
#include "tests/codec/random_mesh.h"
#include "tests/simplify/support.h"
#include "tests/support/adversarial_terrain.h"

namespace tintree::simplify {
namespace {

using codec::TileId;
using codec::TileMesh;
using test::AdversarialTerrain;
using test::Terrain;

TileMesh make(TinMaker& maker, const TileId& id) {
  auto mesh = maker.make(id);
  EXPECT_TRUE(mesh.has_value()) << mesh.error().text();
  return mesh ? std::move(*mesh) : TileMesh{};
}

/// Makes and checks every tile of a tree.
void expect_sound_tree(const Terrain& terrain, int tile_cells, double error_m) {
  SCOPED_TRACE("tile " + std::to_string(tile_cells) + " error " + std::to_string(error_m));
  const codec::TreeLayout layout = test::make_layout(terrain, tile_cells, error_m);
  TinMaker maker(*terrain.surface, layout);
  for (const TileId& id : test::tiles_of(layout)) {
    test::expect_sound_tile(terrain.grid, layout, id, make(maker, id));
    if (testing::Test::HasFailure()) return;
  }
}

class TinMakerTest : public testing::TestWithParam<AdversarialTerrain> {};

TEST_P(TinMakerTest, KeepsItsPromises) {
  const Terrain terrain = test::make_terrain(GetParam().columns, GetParam().rows, GetParam().height);
  for (const auto& [tile_cells, error_m] : {std::pair{64, 0.01}, {64, 3.0}, {256, 0.5}, {256, 100.0}}) {
    expect_sound_tree(terrain, tile_cells, error_m);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, TinMakerTest, testing::ValuesIn(test::everyday_terrains()),
                         [](const auto& shape) { return shape.param.name; });

TEST_P(TinMakerTest, StoresWithTheBestEffortWhatItHasMade) {
  const Terrain terrain = test::make_terrain(GetParam().columns, GetParam().rows, GetParam().height);
  const codec::MeshCodec& codec = *codec::find_codec("tin");
  const codec::TreeLayout layout = test::make_layout(terrain, 32, 1);
  TinMaker maker(*terrain.surface, layout, Effort::kBest);
  for (const TileId& id : test::tiles_of(layout)) {
    const TileMesh mesh = make(maker, id);
    if (mesh.triangles.empty()) continue;
    const auto bytes = maker.encode(codec, id, mesh);
    ASSERT_TRUE(bytes.has_value()) << bytes.error().text();
    EXPECT_EQ(bytes->front(), codec::kTinCoded);
    const auto back = codec.decode(*bytes);
    ASSERT_TRUE(back.has_value()) << back.error().text();
    EXPECT_EQ(test::triangle_set(*back), test::triangle_set(mesh));
    EXPECT_EQ(back->vertices.size(), mesh.vertices.size());
  }
}

TEST(TinMaker, KeepsItsPromisesOnRandomTerrain) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    const double error_m = 0.1 * std::pow(2.0, seed % 7);
    const Terrain terrain = test::make_terrain(90 + static_cast<int>(seed), 70,
                                               test::rough_hills(30, 1, seed % 3 == 0 ? 0 : 0.02 * seed, seed));
    expect_sound_tree(terrain, seed % 2 == 0 ? 16 : 32, error_m);
  }
}

TEST(TinMaker, KeepsItsPromisesInDoublePrecision) {
  // Blocks hold heights in single precision, relative to their middle: a tower spoils that of its own and,
  // along the common samples, that of the next.
  const auto hills = test::rough_hills(4, 1, 0);
  const auto height = [&](int c, int r) { return c == 300 && r == 40 ? 100000.0 / 3 : 5000 + hills(c, r) / 3; };
  expect_sound_tree(test::make_exact_terrain(385, 65, height), 64, 0.1);
}

TEST(TinMaker, TakesACoarseLatticeWhereTrianglesAreLarge) {
  const auto swell = [](int c, int r) { return 20 * std::sin(c / 40.0) * std::cos(r / 40.0); };
  for (const bool rough : {false, true}) {
    const auto noise = test::rough_hills(10, 1, 0);
    const Terrain terrain =
        test::make_terrain(257, 257, [&](int c, int r) { return swell(c, r) + (rough ? noise(c, r) : 0); });
    const codec::TreeLayout layout = test::make_layout(terrain, 256, 1);
    TinMaker maker(*terrain.surface, layout);
    const TileMesh mesh = make(maker, {0, 0, 0});
    test::expect_sound_tile(terrain.grid, layout, {0, 0, 0}, mesh);
    if (rough) {
      EXPECT_EQ(mesh.xy_shift, 0);
    } else {
      EXPECT_GE(mesh.xy_shift, 1);
    }
  }
}

TEST(TinMaker, LeavesTwoTrianglesOfAPlane) {
  for (const double slope : {0.0, 0.25, 8.0}) {
    const Terrain terrain = test::make_terrain(257, 257, [=](int c, int r) { return slope * c - 2 * slope * r + 3; });
    for (const int tile_cells : {16, 64, 256}) {
      const codec::TreeLayout layout = test::make_layout(terrain, tile_cells, 1);
      TinMaker maker(*terrain.surface, layout);
      for (const TileId& id : test::tiles_of(layout)) {
        const TileMesh mesh = make(maker, id);
        EXPECT_EQ(mesh.triangles.size(), 2U) << "slope " << slope << ", tile " << id.text() << " of " << tile_cells;
        EXPECT_EQ(mesh.vertices.size(), 4U);
      }
    }
  }
}

TEST(TinMaker, SimplifiesSmoothTerrainALot) {
  const Terrain terrain = test::make_terrain(257, 257, [](int c, int r) { return test::hills(c, r, 20); });
  const codec::TreeLayout layout = test::make_layout(terrain, 256, 2);
  TinMaker maker(*terrain.surface, layout);
  const TileMesh mesh = make(maker, {});
  EXPECT_LT(mesh.triangles.size(), 2U * 256 * 256 / 20);
}

TEST(TinMaker, MakesNothingWhereThereIsNoSurface) {
  // Single samples and rows of samples are no surface.
  const Terrain terrain = test::make_terrain(65, 65, [](int c, int r) {
    return c < 32 ? 1.0 : r % 2 == 0 ? 2.0 : test::kMissing;
  });
  const codec::TreeLayout layout = test::make_layout(terrain, 32, 1);
  TinMaker maker(*terrain.surface, layout);
  EXPECT_FALSE(make(maker, {1, 0, 0}).triangles.empty());
  EXPECT_TRUE(make(maker, {1, 1, 0}).triangles.empty());
  EXPECT_TRUE(make(maker, {1, 1, 1}).triangles.empty());
}

TEST(TinMaker, MakesTheSameTileWhateverItMadeBefore) {
  const Terrain terrain = test::make_terrain(129, 129, test::rough_hills(30, 2, 0.01));
  const codec::TreeLayout layout = test::make_layout(terrain, 32, 1);
  TinMaker used(*terrain.surface, layout);
  for (const TileId& id : test::tiles_of(layout)) {
    TinMaker fresh(*terrain.surface, layout);
    const TileMesh a = make(used, id);
    const TileMesh b = make(fresh, id);
    EXPECT_EQ(a.vertices, b.vertices) << id.text();
    EXPECT_EQ(a.triangles, b.triangles) << id.text();
    EXPECT_EQ(a.z_offset, b.z_offset);
    EXPECT_EQ(a.xy_shift, b.xy_shift);
  }
}

TEST(TinMaker, UsesTheCoarsestAddressesThatHold) {
  const Terrain terrain = test::make_terrain(257, 257, [](int, int) { return 5.0; });
  const codec::TreeLayout layout = test::make_layout(terrain, 256, 1);
  TinMaker maker(*terrain.surface, layout);
  const TileMesh mesh = make(maker, {});
  EXPECT_EQ(mesh.xy_shift, 8);
  for (const codec::GridVertex& v : mesh.vertices) EXPECT_EQ(v.z, 0);
  EXPECT_EQ(static_cast<double>(mesh.z_offset) * layout.z_step_m[0], 5.0);
}

TEST(TinMaker, StopsWhenAsked) {
  const Terrain terrain = test::make_terrain(129, 129, test::rough_hills(50, 1, 0));
  const codec::TreeLayout layout = test::make_layout(terrain, 128, 1);
  StopFlag stop = false;
  TinMaker maker(*terrain.surface, layout, Effort::kFast, &stop);
  EXPECT_TRUE(maker.make({}).has_value());
  stop = true;
  const auto stopped = maker.make({});
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(stopped.error().code, ErrorCode::kStopped);
}

TEST(TinMaker, RefusesReliefThatTheFormatCannotHold) {
  const Terrain terrain = test::make_terrain(65, 65, [](int c, int) { return c == 30 ? 65536.0 * 8 : 0.0; });
  codec::TreeLayout layout = test::make_layout(terrain, 64, 1);
  layout.z_step_m = {1.0 / 64};
  TinMaker maker(*terrain.surface, layout);
  const auto mesh = maker.make({});
  ASSERT_FALSE(mesh.has_value());
  EXPECT_EQ(mesh.error().code, ErrorCode::kBadData);
  EXPECT_NE(mesh.error().text().find("--error"), std::string::npos);
}

TEST(TileMaker, IsFoundByItsName) {
  const Terrain terrain = test::make_terrain(9, 9, [](int, int) { return 5.0; });
  const codec::TreeLayout layout = test::make_layout(terrain, 8, 1);
  cache::Manifest manifest;
  manifest.layout = layout;
  for (const std::string& method : method_names()) {
    manifest.method = method;
    EXPECT_NE(make_tile_maker(manifest, *terrain.surface), nullptr) << method;
    EXPECT_NE(codec::find_codec(method), nullptr) << method;
  }
  manifest.method = "tun";
  EXPECT_EQ(make_tile_maker(manifest, *terrain.surface), nullptr);
  EXPECT_EQ(codec::find_codec("tun"), nullptr);
}

/// Crops of real elevation models, where the checkout has them.
class RealTerrainTest : public testing::TestWithParam<const char*> {};

TEST_P(RealTerrainTest, KeepsItsPromises) {
  const std::string path = std::string(TINTREE_DATA) + "/" + GetParam();
  if (!cache::RasterSource::open(path)) GTEST_SKIP() << "no " << path;
  const test::HeightGrid whole = test::read_grid(path);
  const std::int64_t left = whole.columns / 3;
  const std::int64_t top = whole.rows / 3;
  const Terrain terrain = test::make_terrain(200, 150, [&](int c, int r) { return whole.at(left + c, top + r); });
  for (const double error_m : {1.0, 15.0}) expect_sound_tree(terrain, 64, error_m);
}

INSTANTIATE_TEST_SUITE_P(Crops, RealTerrainTest,
                         testing::Values("mt_everest_90m.tif", "mt_rainier_90m.tif", "coast_srtm_723x1105.tif",
                                         "ps_height_1k.png"),
                         [](const auto& name) { return "Crop" + std::to_string(name.index); });

}  // namespace
}  // namespace tintree::simplify
