#include "tests/bench/scene/scene_counts.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <gtest/gtest.h>

#include "render/screen_error.h"
#include "tests/support/regular_tree.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::bench {
namespace {

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// A plain of 96 x 64 cells of 3 x 3 m at a height of 5 m, in tiles of 32 cells with a sample in a corner missing.
cache::TileStore plain(const test::TempDir& folder) {
  const std::string dem = folder.file("dem.tif");
  test::write_raster(dem, {.columns = 97, .rows = 65, .dx = 3, .dy = 3},
                     [](int c, int r) { return c == 96 && r == 64 ? test::kMissing : 5.0; });
  const std::string path = folder.file("plain.tintree");
  test::write_tree(path, test::make_regular_tree(dem, {.tile_cells = 32, .leaf_error_m = 0.02, .coarsen = false}));
  return cache::TileStore::open(path).value();
}

TEST(GroundBlocks, HoldEveryTriangleAndAllGroundOnce) {
  const test::TempDir folder;
  const cache::TileStore store = plain(folder);
  for (int level = 0; level <= store.bounds().layout().leaf_level; ++level) {
    const GroundBlocks blocks = ground_blocks(store, level).value();
    double triangles = 0;
    for (const cache::TileNode& node : store.bounds().nodes()) {
      if (node.id.level == level) triangles += store.read(node.id)->info.triangles;
    }
    EXPECT_EQ(blocks.columns, 6);
    EXPECT_EQ(blocks.rows, 4);
    EXPECT_NEAR(sum(blocks.triangles), triangles, 1e-6);
    EXPECT_NEAR(sum(blocks.cells), 96 * 64 - 1, 1e-6);  // the corner's cell has lost both triangles
    EXPECT_NEAR(blocks.triangles[7], 2 * kBlockCells * kBlockCells, 1e-6);
    EXPECT_NEAR(blocks.centres[7].x, 3 * 1.5 * kBlockCells, 1e-6);
    EXPECT_NEAR(blocks.centres[7].y, -3 * 1.5 * kBlockCells, 1e-6);
    EXPECT_NEAR(blocks.centres[7].z, 5, 1e-6);
  }
}

/// 1000 / error² triangles on every block.
ErrorLadder power_law(const GroundBlocks& ground) {
  ErrorLadder ladder;
  for (const double error_m : {0.5, 1.0, 2.0}) {
    GroundBlocks rung = ground;
    rung.triangles.assign(rung.triangles.size(), 1000 / (error_m * error_m));
    ladder.add(error_m, std::move(rung));
  }
  return ladder;
}

TEST(ErrorLadder, FollowsAPowerOfTheErrorBetweenItsRungsAndBeyond) {
  const test::TempDir folder;
  const ErrorLadder ladder = power_law(ground_blocks(plain(folder), 0).value());
  for (const double error_m : {0.5, 0.7, 1.0, 1.9, 2.0, 31.0}) {
    EXPECT_NEAR(ladder.triangles(3, error_m), 1000 / (error_m * error_m), 1e-6) << error_m;
  }
  EXPECT_EQ(ladder.triangles(3, 0.1), 4000);
}

TEST(SceneCounter, CountsAPlainSeenFromAboveAsOneCanByHand) {
  const test::TempDir folder;
  const cache::TileStore store = plain(folder);
  const ErrorLadder ladder = power_law(ground_blocks(store, store.bounds().layout().leaf_level).value());
  const SceneCounter counter = SceneCounter::open(store, ladder).value();
  render::Camera camera;
  camera.target = {144, -96, 5};
  camera.eye = {144, -96, 2005};
  const SceneCounts counts = counter.count(camera).value();

  // 2000 m above everything, where no place moves on the screen by more than a pixel's footprint.
  ASSERT_LT(std::hypot(camera.tan_half_x(), camera.tan_half_y()), 1);
  const double pixel_m = 2000 / camera.focal_px();
  EXPECT_NEAR(counts.full, 2 * (96 * 64 - 1), 1e-6);
  EXPECT_NEAR(counts.fewest_level, 24 * 1000 / (pixel_m * pixel_m), 1e-3);
  EXPECT_NEAR(counts.fewest, counts.fewest_level, 1e-3);
  EXPECT_GE(counts.any_error, counts.fewest);
  EXPECT_EQ(counts.in_picture, counts.drawn);
}

TEST(SceneCounter, LeavesOutWhatThePictureDoesNotShow) {
  const test::TempDir folder;
  const cache::TileStore store = plain(folder);
  const ErrorLadder ladder = power_law(ground_blocks(store, store.bounds().layout().leaf_level).value());
  const SceneCounter counter = SceneCounter::open(store, ladder).value();
  render::Camera camera;  // sees the south-eastern corner, less than a block
  camera.target = {285, -189, 5};
  camera.eye = {285, -189, 25};
  const SceneCounts counts = counter.count(camera).value();
  EXPECT_EQ(counts.tiles, 1U);
  EXPECT_LT(counts.in_picture, counts.drawn);
  camera.target = {285, 100, 5};
  camera.eye = {285, 80, 25};  // northward, away from it
  EXPECT_EQ(counter.count(camera).value().full, 0);
}

TEST(Flight, NeverAsksForLessThanTheLeavesHave) {
  const test::TempDir folder;
  const cache::TileStore store = plain(folder);
  const cache::TileBounds& bounds = store.bounds();
  const cache::Box ground = bounds.box(bounds.nodes()[0]);
  double most_px = 0;
  for (const render::Camera& camera : flight(bounds, 19)) {
    const render::ScreenError screen_error(camera);
    most_px = std::max(most_px, screen_error.bound_px(ground, bounds.layout().leaf_error_m).value_or(0));
  }
  EXPECT_LE(most_px, 1);
  EXPECT_GT(most_px, 0.4);
}

}  // namespace
}  // namespace tintree::bench
