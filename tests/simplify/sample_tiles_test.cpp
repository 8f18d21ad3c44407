#include "simplify/sample_tiles.h"

#include <array>
#include <set>

#include <gtest/gtest.h>

#include "simplify/tile_maker.h"
#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

using codec::TileId;

codec::TreeLayout layout_of(std::int64_t columns, std::int64_t rows, int tile_cells) {
  codec::TreeLayout layout;
  layout.columns = columns;
  layout.rows = rows;
  layout.tile_cells = tile_cells;
  layout.leaf_level = codec::TreeLayout::leaf_level_for(columns, rows, tile_cells);
  return layout;
}

TEST(ChooseSample, SpreadsFewTilesOverALargeTree) {
  const codec::TreeLayout layout = layout_of(40001, 30001, 256);
  const auto levels = choose_sample(layout);
  ASSERT_EQ(levels.size(), 9U);
  double sampled = 0;
  double all = 0;
  for (const LevelSample& level : levels) {
    EXPECT_EQ(level.cells, 40000 * 30000);
    EXPECT_EQ(level.tiles, std::uint64_t{layout.tiles_x(level.level)} * layout.tiles_y(level.level));
    EXPECT_LE(level.sample.size(), 100U);
    std::set<std::int64_t> keys;
    for (const SampledTile& tile : level.sample) keys.insert(tile.id.key());
    EXPECT_EQ(keys.size(), level.sample.size()) << "a tile is there twice";
    sampled += static_cast<double>(level.sampled_cells);
    all += static_cast<double>(level.cells);
  }
  EXPECT_LT(sampled, 0.04 * all);
  EXPECT_EQ(levels.back().sample.size(), 100U);
  EXPECT_TRUE(levels.front().sample.empty());
  // Every quarter of the leaves has its share.
  std::array<int, 4> quarters{};
  for (const SampledTile& tile : levels.back().sample) {
    ++quarters[(tile.id.x > layout.tiles_x(8) / 2 ? 1U : 0U) + (tile.id.y > layout.tiles_y(8) / 2 ? 2U : 0U)];
  }
  for (const int quarter : quarters) EXPECT_GT(quarter, 12);
}

TEST(ChooseSample, TakesAllOfASmallTree) {
  for (const LevelSample& level : choose_sample(layout_of(65, 65, 16))) {
    EXPECT_EQ(level.sample.size(), level.tiles) << level.level;
    EXPECT_EQ(level.sampled_cells, level.cells);
  }
}

TEST(SampleTiles, MakesTheTilesThatABuildMakes) {
  // Several blocks, of which most are never looked at.
  const test::Terrain terrain = test::make_terrain(1800, 1100, test::rough_hills(100, 0.5, 0.001));
  cache::Manifest manifest;
  manifest.layout = test::make_layout(terrain, 64, 4);
  manifest.geotransform = {0, 1, 0, 0, 0, -1};
  const auto sampled = sample_tiles(
      std::make_shared<cache::HeightBlocks>(
          std::shared_ptr<const cache::RasterSource>(&terrain.surface->blocks().source(), [](const auto*) {}), 1 << 24),
      manifest, nullptr);
  ASSERT_TRUE(sampled.has_value()) << sampled.error().text();
  const auto maker = make_tile_maker(manifest, *terrain.surface);
  std::size_t compared = 0;
  for (const LevelSample& level : *sampled) {
    for (const SampledTile& tile : level.sample) {
      if (level.level + 2 < manifest.layout.leaf_level) continue;  // larger ones take long
      const auto mesh = maker->make(tile.id);
      ASSERT_TRUE(mesh.has_value());
      // The guard may differ in its last digits where a neighbour's heights are not known.
      EXPECT_NEAR(static_cast<double>(tile.vertices), static_cast<double>(mesh->vertices.size()),
                  0.01 * static_cast<double>(mesh->vertices.size()) + 2);
      EXPECT_GT(tile.bytes, 0U);
      ++compared;
    }
  }
  EXPECT_GT(compared, 20U);
}

TEST(SampleTiles, StopsWhenAsked) {
  const test::Terrain terrain = test::make_terrain(100, 100, test::rough_hills(100, 0.5, 0));
  cache::Manifest manifest;
  manifest.layout = test::make_layout(terrain, 64, 4);
  const StopFlag stop = true;
  const auto blocks = std::shared_ptr<cache::HeightBlocks>(&terrain.surface->blocks(), [](auto*) {});
  const auto sampled = sample_tiles(blocks, manifest, &stop);
  ASSERT_FALSE(sampled.has_value());
  EXPECT_EQ(sampled.error().code, ErrorCode::kStopped);
}

}  // namespace
}  // namespace tintree::simplify
