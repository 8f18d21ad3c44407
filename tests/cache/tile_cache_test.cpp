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

  /// All tiles of the tree, as a view asks for them.
  std::vector<TileRef> all() const {
    std::vector<TileRef> out;
    for (const TileId& id : tree_.tiles()) out.push_back({id});
    return out;
  }

  test::AnalyticTree tree_;
  std::string path_;
  std::optional<TileStore> store_;
};

TEST_F(TileCacheTest, BringsWhatIsAskedFor) {
  TileCache cache(*store_, {});
  EXPECT_EQ(cache.get({{0, 0, 0}}), nullptr);
  const std::vector<TileRef> ids = all();
  cache.request(ids);
  cache.wait_idle();
  EXPECT_TRUE(cache.idle());
  std::size_t bytes = 0;
  for (const TileRef& ref : ids) {
    const auto tile = cache.get(ref);
    ASSERT_NE(tile, nullptr) << ref.id.text();
    EXPECT_EQ(tile->id, ref.id);
    EXPECT_EQ(tile->surface_triangles, tree_.mesh(ref.id).triangles.size());
    bytes += tile->bytes();
  }
  EXPECT_EQ(cache.stats().bytes, bytes);
  EXPECT_EQ(cache.stats().loaded, ids.size());
  EXPECT_TRUE(cache.take_errors().empty());
}

TEST_F(TileCacheTest, AsksOnceForWhatIsHere) {
  TileCache cache(*store_, {});
  const std::vector<TileRef> ids{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 0, 0}}};
  for (int i = 0; i < 3; ++i) {
    cache.request(ids);
    cache.wait_idle();
  }
  EXPECT_EQ(cache.stats().loaded, 2U);
}

TEST_F(TileCacheTest, ANewRequestReplacesTheOld) {
  TileCache cache(*store_, {});
  const std::vector<TileRef> all = this->all();
  cache.request(all);
  cache.request({});
  cache.wait_idle();
  EXPECT_LE(cache.stats().loaded, all.size());
  cache.request(std::vector<TileRef>(1, all.back()));
  cache.wait_idle();
  EXPECT_NE(cache.get(all.back()), nullptr);
}

TEST_F(TileCacheTest, KeepsToItsBytesAndDropsTheLeastRecentlyUsed) {
  const std::vector<TileRef> leaves{{{2, 1, 1}}, {{2, 2, 1}}, {{2, 1, 2}}, {{2, 2, 2}}};
  const std::size_t one = make_drawable(tree_.layout(), leaves[0].id, tree_.mesh(leaves[0].id)).bytes();
  TileCache cache(*store_, {.bytes = 3 * one});
  for (const TileRef& id : leaves) {
    for (int idle_round = 0; idle_round < 3; ++idle_round) cache.request({});
    if (id == leaves[3]) {
      EXPECT_NE(cache.get(leaves[0]), nullptr);  // Now the second is the oldest.
    }
    cache.request(std::vector<TileRef>(1, id));
    cache.wait_idle();
  }
  EXPECT_LE(cache.stats().bytes, 3 * one);
  EXPECT_NE(cache.get(leaves[0]), nullptr);
  EXPECT_EQ(cache.get(leaves[1]), nullptr);
  EXPECT_NE(cache.get(leaves[3]), nullptr);
}

TEST_F(TileCacheTest, AViewLargerThanTheCacheIsServedAllTheSame) {
  TileCache cache(*store_, {.bytes = 1});
  const std::vector<TileRef> all = this->all();
  cache.request(all);
  cache.wait_idle();
  for (const TileRef& id : all) EXPECT_NE(cache.get(id), nullptr);
  for (int i = 0; i < 3; ++i) cache.request({});
  EXPECT_EQ(cache.stats().tiles, 0U);
}

TEST_F(TileCacheTest, ReportsADamagedTileOnceAndServesTheOthers) {
  const TileId bad{1, 1, 0};
  damage(bad);
  TileCache cache(*store_, {});
  const std::vector<TileRef> ids{{bad}, {{1, 0, 0}}};
  cache.request(ids);
  cache.wait_idle();
  const std::vector<Error> errors = cache.take_errors();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].code, ErrorCode::kBadData);
  EXPECT_NE(errors[0].text().find(bad.text()), std::string::npos);
  EXPECT_NE(errors[0].text().find(path_), std::string::npos);
  EXPECT_NE(cache.get({{1, 0, 0}}), nullptr);
  cache.request(ids);
  cache.wait_idle();
  EXPECT_TRUE(cache.take_errors().empty());
  EXPECT_EQ(cache.get({bad}), nullptr);
  EXPECT_TRUE(cache.lost({bad}));
  EXPECT_FALSE(cache.lost({{1, 0, 0}}));
}

TEST_F(TileCacheTest, LoadsAheadWhatFitsAndNeverAtTheCostOfWhatIsNeeded) {
  const std::vector<TileRef> leaves{{{2, 1, 1}}, {{2, 2, 1}}, {{2, 1, 2}}, {{2, 2, 2}}};
  const auto bytes = [&](std::size_t i) {
    return make_drawable(tree_.layout(), leaves[i].id, tree_.mesh(leaves[i].id)).bytes();
  };
  TileCache cache(*store_, {.bytes = bytes(0) + bytes(1) + bytes(2) + 200});
  const std::span<const TileRef> all(leaves);
  const auto settled = [&](std::size_t tiles) {
    for (int i = 0; i < 2000 && cache.stats().tiles < tiles; ++i) usleep(1000);
    usleep(20000);  // What should not come has had its chance.
    return cache.stats();
  };
  cache.request(all.first(1), all.subspan(1));
  cache.wait_idle();
  EXPECT_NE(cache.get(leaves[0]), nullptr);
  EXPECT_EQ(settled(3).ahead, 2U);  // The rest of the budget, in their order.
  EXPECT_LE(cache.stats().bytes, bytes(0) + bytes(1) + bytes(2) + 200);
  EXPECT_EQ(cache.stats().evicted, 0U);
  const std::uint64_t read = cache.stats().bytes_read;
  for (int i = 0; i < 5; ++i) cache.request(all.first(1), all.subspan(1));
  EXPECT_EQ(settled(3).bytes_read, read);  // It does not read the same again and again.
  cache.request(std::vector<TileRef>{leaves[0], leaves[3]}, all.subspan(1, 2));
  cache.wait_idle();
  EXPECT_NE(cache.get(leaves[3]), nullptr);
  EXPECT_NE(cache.get(leaves[0]), nullptr);
  EXPECT_EQ(cache.stats().evicted, 1U);  // The less urgent of the two ahead.
  EXPECT_NE(cache.get(leaves[1]), nullptr);
  EXPECT_EQ(cache.get(leaves[2]), nullptr);
}

TEST_F(TileCacheTest, TheQueueIsBounded) {
  TileCache cache(*store_, {.queue = 3});
  cache.request(all());
  cache.wait_idle();
  EXPECT_LE(cache.stats().loaded, 4U);  // Three, and one that was begun before the queue was full.
  EXPECT_GE(cache.stats().loaded, 3U);
  EXPECT_NE(cache.get({{0, 0, 0}}), nullptr);
}

TEST_F(TileCacheTest, ServesSeveralTreesAndKeepsThemApart) {
  test::AnalyticTree other;
  other.height_m = [](double, double) { return 7; };
  const std::string path = path_ + ".other";
  other.write(path);
  const TileStore second = std::move(*TileStore::open(path));
  codec::TreeLayout moved = second.manifest().layout;
  moved.origin_m = {5000, -300};
  TileCache cache({{&*store_, store_->manifest().layout, 0}, {&second, moved, kSkirtWest}}, {});
  const TileId id{1, 0, 0};
  cache.request(std::vector<TileRef>{{id, 0}, {id, 1}});
  cache.wait_idle();
  const auto a = cache.get({id, 0});
  const auto b = cache.get({id, 1});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->frame.world({0, 0, 0})[0], 0);
  EXPECT_EQ(b->frame.world({0, 0, 0})[0], 5000);
  EXPECT_EQ(b->frame.world({0, 0, 0})[1], -300);
  EXPECT_EQ(b->index_count() - 3 * b->surface_triangles, 3U * 32 * 2 * 3);  // West, too.
  EXPECT_EQ(a->index_count() - 3 * a->surface_triangles, 2U * 32 * 2 * 3);
  std::filesystem::remove(path);
}

TEST_F(TileCacheTest, EndsWhileWorkWaits) {
  for (int i = 0; i < 20; ++i) {
    TileCache cache(*store_, {});
    cache.request(all());
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
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) EXPECT_EQ(tile.vertices[i].z(), mesh.vertices[i].z);
}

TEST(DrawableTile, PacksEveryAddressTheVertexHolds) {
  for (const std::int32_t xy : {0, 1, 65535, 65536, 300001, DrawVertex::kMostXy}) {
    for (const std::int32_t z : {0, 65535, 65536, 4000001, DrawVertex::kMostZ}) {
      const DrawVertex v = DrawVertex::pack(xy, DrawVertex::kMostXy - xy, z);
      EXPECT_EQ(v.x(), xy);
      EXPECT_EQ(v.y(), DrawVertex::kMostXy - xy);
      EXPECT_EQ(v.z(), z);
      EXPECT_EQ(v.skirt(), 0);
    }
  }
}

// A tile wider than the vertex holds is drawn within half a step of what is left.
TEST(DrawableTile, RoundsWhatIsWiderThanTheVertexHolds) {
  test::AnalyticTree tree;
  tree.columns = tree.rows = (std::int64_t{1} << 21) + 1;
  tree.tile_cells = 1 << 16;
  codec::TileMesh mesh;
  const TileId id{0, 0, 0};
  mesh.vertices = {{0, 0, 5}, {1 << 21, 0, 6}, {0, 1 << 21, 7}, {1000003, 3, 8}};
  mesh.triangles = {{0, 2, 1}, {0, 2, 3}};
  const DrawableTile tile = make_drawable(tree.layout(), id, mesh);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto& v = tile.vertices[i];
    EXPECT_NEAR(tile.frame.column(v.x()), mesh.vertices[i].x, 4);
    EXPECT_NEAR(tile.frame.row(v.y()), mesh.vertices[i].y, 4);
  }
}

TEST(DrawableTile, NamesManyVerticesIn32Bits) {
  test::AnalyticTree tree;
  tree.columns = tree.rows = 300;
  tree.tile_cells = 512;
  const TileId id{0, 0, 0};
  const codec::TileMesh mesh = tree.mesh(id);
  ASSERT_GT(mesh.vertices.size(), 65536U);
  const DrawableTile tile = make_drawable(tree.layout(), id, mesh);
  ASSERT_EQ(tile.index_count(), 3 * mesh.triangles.size());
  EXPECT_TRUE(tile.indices.empty());
  EXPECT_EQ(tile.index(tile.index_count() - 1), mesh.triangles.back()[2]);
}

TEST(DrawableTile, SkirtHangsOnEverySideThatHasANeighbour) {
  const test::AnalyticTree tree;  // 4 x 4 leaves of 32 cells.
  for (const auto& [id, sides] : {std::pair(TileId{2, 0, 0}, 2), std::pair(TileId{2, 1, 2}, 4),
                                  std::pair(TileId{2, 3, 1}, 3), std::pair(TileId{0, 0, 0}, 0)}) {
    const codec::TileMesh mesh = tree.mesh(id);
    const DrawableTile tile = make_drawable(tree.layout(), id, mesh);
    EXPECT_EQ(tile.index_count() / 3 - tile.surface_triangles, static_cast<std::size_t>(sides) * 32 * 2) << id.text();
    for (std::size_t i = 0; i < tile.vertices.size(); ++i)
      EXPECT_EQ(tile.vertices[i].skirt() != 0, i >= mesh.vertices.size());
    for (std::size_t i = 0; i < tile.index_count(); ++i) EXPECT_LT(tile.index(i), tile.vertices.size());
  }
}

TEST(DrawableTile, SkirtSharesPlaceAndNormalWithItsBorder) {
  const test::AnalyticTree tree;
  const TileId id{1, 0, 0};
  const DrawableTile tile = make_drawable(tree.layout(), id, tree.mesh(id));
  std::set<std::tuple<int, int, int, int, int>> surface;
  const auto place = [](const DrawVertex& v) {
    return std::tuple(v.x(), v.y(), v.z(), int{v.normal_x}, int{v.normal_y});
  };
  for (const DrawVertex& v : tile.vertices) {
    if (v.skirt() == 0) surface.insert(place(v));
  }
  for (const DrawVertex& v : tile.vertices) {
    if (v.skirt() == 0) continue;
    EXPECT_TRUE(surface.contains(place(v)));
    EXPECT_EQ((v.skirt() & kSkirtEast) != 0, v.x() == 64);
    EXPECT_EQ((v.skirt() & kSkirtSouth) != 0, v.y() == 64);
    EXPECT_EQ(v.skirt() & (kSkirtWest | kSkirtNorth), 0);
  }
}

}  // namespace
}  // namespace tintree::cache
