/// Whole trees of method `wavelet`, checked tile by tile on the stored bytes by brute force.

#include "simplify/wavelet_maker.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "codec/mesh_codec.h"
#include "simplify/stored_tile.h"
#include "tests/simplify/support.h"
#include "tests/simplify/whole_tree.h"
#include "tests/support/adversarial_terrain.h"
#include "tests/support/temp_dir.h"

namespace tintree::simplify {
namespace {

using test::Terrain;

Expected<test::WholeTree> build(const Terrain& terrain, int tile_cells, double error_m, const std::string& path) {
  const double accepted_m = test::accepted_error_m(terrain, tile_cells, error_m);
  return test::build_whole_tree(terrain, test::make_layout(terrain, tile_cells, accepted_m), path, "fast", "wavelet");
}

cache::Manifest manifest_of(const codec::TreeLayout& layout, const std::string& criterion) {
  cache::Manifest manifest;
  manifest.method = "wavelet";
  manifest.criterion = criterion;
  manifest.layout = layout;
  return manifest;
}

class WaveletTreeTest : public testing::TestWithParam<test::AdversarialTerrain> {};

TEST_P(WaveletTreeTest, KeepsItsPromises) {
  const test::AdversarialTerrain& shape = GetParam();
  SCOPED_TRACE(shape.about);
  const test::TempDir dir;
  test::write_terrain(dir.file("dem.tif"), shape);
  const Terrain terrain = test::read_terrain(dir.file("dem.tif"));
  if (!terrain.surface->has_surface()) return;
  for (const double share : {1e-3, 0.05}) {
    SCOPED_TRACE(share);
    const auto tree =
        build(terrain, shape.columns > 100 ? 32 : 16, share * test::relief_m(terrain.grid), dir.file("t.tintree"));
    ASSERT_TRUE(tree.has_value()) << tree.error().text();
    test::expect_sound_tree(terrain, *tree);
  }
}

INSTANTIATE_TEST_SUITE_P(Terrains, WaveletTreeTest, testing::ValuesIn(test::adversarial_terrains()),
                         [](const auto& shape) { return shape.param.name; });

/// A tile is the same whether it is made first of all, by a maker of its own, or last.
TEST(WaveletMaker, ATileIsAFunctionOfTheSamples) {
  const test::TempDir dir;
  const Terrain terrain = test::make_terrain(150, 130, test::rough_hills(60, 3, 0.01));
  const auto tree = build(terrain, 32, 1, dir.file("t.tintree"));
  ASSERT_TRUE(tree.has_value()) << tree.error().text();
  const cache::Manifest& manifest = tree->store.manifest();
  for (const codec::TileId& id : test::tiles_of(manifest.layout)) {
    const auto stored = tree->store.read(id);
    ASSERT_TRUE(stored.has_value());
    const auto maker = make_tile_maker(manifest, *terrain.surface);
    const auto tile = make_stored_tile(*maker, *codec::find_codec("wavelet"), manifest.layout, id);
    ASSERT_TRUE(tile.has_value());
    EXPECT_TRUE(tile->payload == stored->payload) << id.text();
  }
}

/// What the patches keep to changes the bytes alone: the mesh is within the bound either way.
TEST(WaveletMaker, TheCriterionLeavesTheMeshAsItIs) {
  const Terrain terrain = test::make_terrain(65, 65, test::rough_hills(60, 3, 0));
  const codec::TreeLayout layout = test::make_layout(terrain, 32, 0.5);
  const codec::TileId leaf{1, 1, 0};
  std::vector<std::size_t> sizes;
  std::vector<codec::TileMesh> meshes;
  for (const char* criterion : {"max", "rms"}) {
    const auto maker = make_tile_maker(manifest_of(layout, criterion), *terrain.surface);
    auto mesh = maker->make(leaf);
    ASSERT_TRUE(mesh.has_value());
    const auto payload = maker->encode(*codec::find_codec("wavelet"), leaf, *mesh);
    ASSERT_TRUE(payload.has_value());
    sizes.push_back(payload->size());
    meshes.push_back(std::move(*mesh));
  }
  EXPECT_NE(sizes[0], sizes[1]);
  EXPECT_EQ(meshes[0].vertices, meshes[1].vertices);
}

/// A tile whose parent is damaged says which tile it lacks.
TEST(WaveletDecoder, FailsWithItsReader) {
  const Terrain terrain = test::make_terrain(65, 65, test::rough_hills(60, 3, 0));
  const codec::TreeLayout layout = test::make_layout(terrain, 32, 0.5);
  const auto maker = make_tile_maker(manifest_of(layout, "rms"), *terrain.surface);
  const auto tile = make_stored_tile(*maker, *codec::find_codec("wavelet"), layout, {1, 0, 0});
  ASSERT_TRUE(tile.has_value());
  const auto decoder = codec::make_tile_decoder("wavelet", layout, [](const codec::TileId& id) {
    return fail(ErrorCode::kBadData, "is damaged", "tile " + id.text());
  });
  const auto mesh = decoder->decode({1, 0, 0}, tile->payload);
  ASSERT_FALSE(mesh.has_value());
  EXPECT_EQ(mesh.error().where, "tile 0/0/0");
}

}  // namespace
}  // namespace tintree::simplify
