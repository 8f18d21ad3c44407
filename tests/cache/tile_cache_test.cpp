#include "cache/tile_cache.h"

#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include "tests/render/analytic_tree.h"

namespace tintree::cache {
namespace {

using codec::TileId;

class TileCacheTest : public testing::Test {
 protected:
  void SetUp() override {
    path_ = testing::TempDir() + "tile_cache_test." + std::to_string(getpid()) + ".tintree";
    tree_.write(path_);
    store_.emplace(std::move(*TileStore::open(path_)));
  }
  void TearDown() override {
    store_.reset();
    std::filesystem::remove(path_);
  }

  /// Changes a tile's bytes behind the store's back.
  void damage(const TileId& id) const {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
    const std::string sql =
        "UPDATE tile SET payload = zeroblob(length(payload)) WHERE key = " + std::to_string(id.key());
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close(db);
  }

  test::AnalyticTree tree_;
  std::string path_;
  std::optional<TileStore> store_;
};

TEST_F(TileCacheTest, BringsWhatIsAskedFor) {
  TileCache cache(*store_, {});
  EXPECT_EQ(cache.get({0, 0, 0}), nullptr);
  const std::vector<TileId> ids = tree_.tiles();
  cache.request(ids);
  cache.wait_idle();
  EXPECT_TRUE(cache.idle());
  std::size_t bytes = 0;
  for (const TileId& id : ids) {
    const auto tile = cache.get(id);
    ASSERT_NE(tile, nullptr) << id.text();
    EXPECT_EQ(tile->id, id);
    EXPECT_EQ(tile->surface_triangles, tree_.mesh(id).triangles.size());
    bytes += tile->bytes();
  }
  EXPECT_EQ(cache.stats().bytes, bytes);
  EXPECT_EQ(cache.stats().loaded, ids.size());
  EXPECT_TRUE(cache.take_errors().empty());
}

TEST_F(TileCacheTest, AsksOnceForWhatIsHere) {
  TileCache cache(*store_, {});
  const std::vector<TileId> ids{{0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  for (int i = 0; i < 3; ++i) {
    cache.request(ids);
    cache.wait_idle();
  }
  EXPECT_EQ(cache.stats().loaded, 2U);
}

TEST_F(TileCacheTest, ANewRequestReplacesTheOld) {
  TileCache cache(*store_, {});
  const std::vector<TileId> all = tree_.tiles();
  cache.request(all);
  cache.request({});
  cache.wait_idle();
  EXPECT_LE(cache.stats().loaded, all.size());
  cache.request(std::vector<TileId>(1, all.back()));
  cache.wait_idle();
  EXPECT_NE(cache.get(all.back()), nullptr);
}

TEST_F(TileCacheTest, KeepsToItsBytesAndDropsTheLeastRecentlyUsed) {
  const std::vector<TileId> leaves{{2, 1, 1}, {2, 2, 1}, {2, 1, 2}, {2, 2, 2}};
  const std::size_t one = make_drawable(tree_.layout(), leaves[0], tree_.mesh(leaves[0])).bytes();
  TileCache cache(*store_, {.bytes = 3 * one});
  for (const TileId& id : leaves) {
    for (int idle_round = 0; idle_round < 3; ++idle_round) cache.request({});
    if (id == leaves[3]) {
      EXPECT_NE(cache.get(leaves[0]), nullptr);  // Now the second is the oldest.
    }
    cache.request(std::vector<TileId>(1, id));
    cache.wait_idle();
  }
  EXPECT_LE(cache.stats().bytes, 3 * one);
  EXPECT_NE(cache.get(leaves[0]), nullptr);
  EXPECT_EQ(cache.get(leaves[1]), nullptr);
  EXPECT_NE(cache.get(leaves[3]), nullptr);
}

TEST_F(TileCacheTest, AViewLargerThanTheCacheIsServedAllTheSame) {
  TileCache cache(*store_, {.bytes = 1});
  const std::vector<TileId> all = tree_.tiles();
  cache.request(all);
  cache.wait_idle();
  for (const TileId& id : all) EXPECT_NE(cache.get(id), nullptr);
  for (int i = 0; i < 3; ++i) cache.request({});
  EXPECT_EQ(cache.stats().tiles, 0U);
}

TEST_F(TileCacheTest, ReportsADamagedTileOnceAndServesTheOthers) {
  const TileId bad{1, 1, 0};
  damage(bad);
  TileCache cache(*store_, {});
  const std::vector<TileId> ids{bad, {1, 0, 0}};
  cache.request(ids);
  cache.wait_idle();
  const std::vector<Error> errors = cache.take_errors();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].code, ErrorCode::kBadData);
  EXPECT_NE(errors[0].text().find(bad.text()), std::string::npos);
  EXPECT_NE(errors[0].text().find(path_), std::string::npos);
  EXPECT_NE(cache.get({1, 0, 0}), nullptr);
  cache.request(ids);
  cache.wait_idle();
  EXPECT_TRUE(cache.take_errors().empty());
  EXPECT_EQ(cache.get(bad), nullptr);
}

TEST_F(TileCacheTest, EndsWhileWorkWaits) {
  for (int i = 0; i < 20; ++i) {
    TileCache cache(*store_, {});
    cache.request(tree_.tiles());
  }
}

TEST(DrawableTile, NormalsAreThoseOfThePlane) {
  test::AnalyticTree tree;
  tree.height_m = [](double x, double y) { return 0.5 * x - 0.25 * y; };
  const TileId id{2, 1, 2};
  const DrawableTile tile = make_drawable(tree.layout(), id, tree.mesh(id));
  const double length = std::sqrt(0.25 + 0.0625 + 1);
  for (const DrawVertex& v : tile.vertices) {
    EXPECT_NEAR(v.normal_x / 32767.0, -0.5 / length, 1e-4);
    EXPECT_NEAR(v.normal_y / 32767.0, 0.25 / length, 1e-4);
  }
}

TEST(DrawableTile, KeepsEveryHeightTheFormatAllows) {
  const test::AnalyticTree tree;
  const TileId id{2, 1, 2};
  codec::TileMesh mesh = tree.mesh(id);
  mesh.vertices[0].z = codec::kMaxHeightAddress;
  mesh.vertices[1].z = 65536 + 7;
  const DrawableTile tile = make_drawable(tree.layout(), id, mesh);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    EXPECT_EQ(tile.vertices[i].z, static_cast<float>(mesh.vertices[i].z));
}

TEST(DrawableTile, SkirtHangsOnEverySideThatHasANeighbour) {
  const test::AnalyticTree tree;  // 4 x 4 leaves of 32 cells.
  for (const auto& [id, sides] : {std::pair(TileId{2, 0, 0}, 2), std::pair(TileId{2, 1, 2}, 4),
                                  std::pair(TileId{2, 3, 1}, 3), std::pair(TileId{0, 0, 0}, 0)}) {
    const codec::TileMesh mesh = tree.mesh(id);
    const DrawableTile tile = make_drawable(tree.layout(), id, mesh);
    EXPECT_EQ(tile.indices.size() / 3 - tile.surface_triangles, static_cast<std::size_t>(sides) * 32 * 2) << id.text();
    for (std::size_t i = 0; i < tile.vertices.size(); ++i)
      EXPECT_EQ(tile.vertices[i].skirt != 0, i >= mesh.vertices.size());
    for (const std::uint32_t i : tile.indices) EXPECT_LT(i, tile.vertices.size());
  }
}

TEST(DrawableTile, SkirtSharesPlaceAndNormalWithItsBorder) {
  const test::AnalyticTree tree;
  const TileId id{1, 0, 0};
  const DrawableTile tile = make_drawable(tree.layout(), id, tree.mesh(id));
  std::set<std::tuple<float, float, int, int, int>> surface;
  const auto place = [](const DrawVertex& v) { return std::tuple(v.x, v.y, v.z, int{v.normal_x}, int{v.normal_y}); };
  for (const DrawVertex& v : tile.vertices) {
    if (v.skirt == 0) surface.insert(place(v));
  }
  for (const DrawVertex& v : tile.vertices) {
    if (v.skirt == 0) continue;
    EXPECT_TRUE(surface.contains(place(v)));
    EXPECT_EQ((v.skirt & kSkirtEast) != 0, v.x == 64.0F);
    EXPECT_EQ((v.skirt & kSkirtSouth) != 0, v.y == 64.0F);
    EXPECT_EQ(v.skirt & (kSkirtWest | kSkirtNorth), 0);
  }
}

}  // namespace
}  // namespace tintree::cache
