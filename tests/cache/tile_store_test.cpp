#include "cache/tile_store.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/regular_tree.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::cache {
namespace {

namespace fs = std::filesystem;
using codec::TileId;
using test::TestTree;

/// A tree of three levels with a hole, made once for all tests.
const TestTree& small_tree() {
  static const TestTree tree = [] {
    const test::TempDir dir;
    test::write_raster(dir.file("dem.tif"), {.columns = 60, .rows = 45}, [](int c, int r) {
      return c > 20 && c < 27 && r > 8 && r < 14 ? test::kMissing : test::hills(c, r);
    });
    return test::make_regular_tree(dir.file("dem.tif"));
  }();
  return tree;
}

void expect_same_tile(const StoredTile& a, const StoredTile& b) {
  EXPECT_EQ(a.info.id, b.info.id);
  EXPECT_EQ(a.info.vertices, b.info.vertices);
  EXPECT_EQ(a.info.triangles, b.info.triangles);
  EXPECT_EQ(a.info.z_min_m, b.info.z_min_m);
  EXPECT_EQ(a.info.z_max_m, b.info.z_max_m);
  EXPECT_EQ(a.info.error_m, b.info.error_m);
  EXPECT_EQ(a.info.rms_m, b.info.rms_m);
  EXPECT_EQ(a.info.border_error_m, b.info.border_error_m);
  EXPECT_EQ(a.payload, b.payload);
}

class TileStoreTest : public testing::Test {
 protected:
  TileWriter create() {
    auto writer = TileWriter::create(path_, small_tree().manifest);
    if (!writer) throw std::runtime_error(writer.error().text());
    return std::move(*writer);
  }
  void put(TileWriter& writer, const StoredTile& tile) {
    const auto done = writer.put(tile);
    if (!done) throw std::runtime_error(done.error().text());
  }
  Error open_error(const std::string& path) {
    const auto store = TileStore::open(path);
    if (store) throw std::runtime_error("was opened");
    EXPECT_EQ(store.error().where, path);
    return store.error();
  }

  test::TempDir dir_;
  std::string path_ = dir_.file("t.tintree");
};

TEST_F(TileStoreTest, GivesBackWhatWasPut) {
  const TestTree& tree = small_tree();
  ASSERT_GT(tree.tiles.size(), 15U);
  test::write_tree(path_, tree);
  const auto store = TileStore::open(path_);
  ASSERT_TRUE(store.has_value()) << store.error().text();
  EXPECT_EQ(store->path(), path_);
  EXPECT_TRUE(store->manifest().complete);
  EXPECT_EQ(store->manifest().digest.size(), 32U);
  EXPECT_EQ(store->digest().value(), store->manifest().digest);
  ASSERT_EQ(store->keys().value().size(), store->bounds().nodes().size());
  for (std::size_t i = 0; i < store->keys()->size(); ++i) {
    EXPECT_EQ(store->keys().value()[i], store->bounds().nodes()[i].id.key());
  }
  ASSERT_EQ(store->bounds().nodes().size(), tree.tiles.size());
  for (std::size_t i = 0; i < tree.tiles.size(); ++i) {
    EXPECT_EQ(store->bounds().nodes()[i].id, tree.tiles[i].info.id);
    const auto tile = store->read(tree.tiles[i].info.id);
    ASSERT_TRUE(tile.has_value()) << tile.error().text();
    expect_same_tile(*tile, tree.tiles[i]);
    const auto mesh = store->read_mesh(tree.tiles[i].info.id);
    ASSERT_TRUE(mesh.has_value()) << mesh.error().text();
    EXPECT_EQ(mesh->triangles.size(), tree.tiles[i].info.triangles);
    EXPECT_EQ(mesh->vertices.size(), tree.tiles[i].info.vertices);
  }
}

TEST_F(TileStoreTest, AFinishedTreeIsOneFile) {
  test::write_tree(path_, small_tree());
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(dir_.path())) names.push_back(entry.path().filename().string());
  EXPECT_EQ(names, std::vector<std::string>{"t.tintree"});
  const std::string header = test::read_file(path_).substr(0, 100);
  EXPECT_EQ(header.substr(68, 4), "TINT");
  EXPECT_EQ(header.substr(60, 4), std::string("\0\0\0\1", 4));
  EXPECT_EQ(header.substr(18, 2), std::string("\1\1", 2)) << "not in rollback mode";
}

TEST_F(TileStoreTest, DigestDoesNotDependOnTheOrder) {
  std::mt19937 random(1);
  std::string first;
  for (int i = 0; i < 4; ++i) {
    auto tiles = small_tree().tiles;
    if (i > 0) std::ranges::shuffle(tiles, random);
    TileWriter writer = create();
    for (const auto& tile : tiles) {
      put(writer, tile);
      if (random() % 5 == 0) {
        ASSERT_TRUE(writer.commit().has_value());
      }
    }
    const auto digest = writer.finish();
    ASSERT_TRUE(digest.has_value()) << digest.error().text();
    if (i == 0) first = *digest;
    EXPECT_EQ(*digest, first);
    EXPECT_EQ(TileStore::open(path_)->manifest().digest, first);
  }
}

TEST_F(TileStoreTest, DigestDependsOnEveryFigure) {
  const auto digest_with = [this](const std::function<void(StoredTile&)>& change) {
    TileWriter writer = create();
    for (StoredTile tile : small_tree().tiles) {
      if (tile.info.id == TileId{1, 0, 0}) change(tile);
      put(writer, tile);
    }
    return writer.finish().value();
  };
  const std::string plain = digest_with([](StoredTile&) {});
  EXPECT_NE(plain, digest_with([](StoredTile& t) { t.info.error_m += 1e-9; }));
  EXPECT_NE(plain, digest_with([](StoredTile& t) { t.info.border_error_m += 1e-9; }));
  EXPECT_NE(plain, digest_with([](StoredTile& t) { t.info.rms_m += 1e-9; }));
  EXPECT_NE(plain, digest_with([](StoredTile& t) { t.info.z_max_m += 1e-9; }));
  EXPECT_NE(plain, digest_with([](StoredTile& t) { t.info.vertices += 1; }));
  EXPECT_NE(plain, digest_with([](StoredTile& t) { t.payload.back() ^= std::byte{1}; }));
}

TEST_F(TileStoreTest, PutReplaces) {
  TileWriter writer = create();
  for (StoredTile tile : small_tree().tiles) {
    tile.info.error_m = 1e6;
    put(writer, tile);
  }
  for (const auto& tile : small_tree().tiles) put(writer, tile);
  ASSERT_TRUE(writer.finish().has_value());
  const auto store = TileStore::open(path_);
  ASSERT_TRUE(store.has_value());
  expect_same_tile(*store->read({}), small_tree().tiles[0]);
}

TEST_F(TileStoreTest, WriterListsAndReadsItsTiles) {
  TileWriter writer = create();
  auto tiles = small_tree().tiles;
  std::ranges::reverse(tiles);
  for (const auto& tile : tiles) put(writer, tile);
  const auto keys = writer.keys();
  ASSERT_TRUE(keys.has_value());
  EXPECT_EQ(keys->size(), tiles.size());
  EXPECT_TRUE(std::ranges::is_sorted(*keys));
  expect_same_tile(*writer.read(tiles[3].info.id), tiles[3]);
  EXPECT_FALSE(writer.read({9, 9, 9}).has_value());
}

TEST_F(TileStoreTest, GoesOnAfterAStop) {
  test::write_tree(dir_.file("whole.tintree"), small_tree());
  const auto& tiles = small_tree().tiles;
  {
    TileWriter writer = create();
    for (std::size_t i = 0; i < 7; ++i) put(writer, tiles[i]);
  }
  EXPECT_FALSE(fs::exists(path_));
  EXPECT_TRUE(fs::exists(TileWriter::building_path(path_)));
  auto writer = TileWriter::resume(path_, small_tree().manifest);
  ASSERT_TRUE(writer.has_value()) << writer.error().text();
  EXPECT_EQ(writer->keys()->size(), 7U);
  for (std::size_t i = 7; i < tiles.size(); ++i) put(*writer, tiles[i]);
  ASSERT_TRUE(writer->finish().has_value());
  EXPECT_EQ(TileStore::open(path_)->manifest().digest, TileStore::open(dir_.file("whole.tintree"))->manifest().digest);
}

TEST_F(TileStoreTest, ResumeNamesTheOptionThatDiffers) {
  { TileWriter writer = create(); }
  Manifest other = small_tree().manifest;
  other.layout.leaf_error_m *= 2;
  const auto writer = TileWriter::resume(path_, other);
  ASSERT_FALSE(writer.has_value());
  EXPECT_EQ(writer.error().code, ErrorCode::kUsage);
  EXPECT_NE(writer.error().message.find("--error"), std::string::npos) << writer.error().text();
}

TEST_F(TileStoreTest, ResumeNeedsAnUnfinishedBuild) {
  const auto writer = TileWriter::resume(path_, small_tree().manifest);
  ASSERT_FALSE(writer.has_value());
  EXPECT_EQ(writer.error().code, ErrorCode::kUsage);
}

TEST_F(TileStoreTest, CreateDiscardsAnUnfinishedBuild) {
  {
    TileWriter writer = create();
    put(writer, small_tree().tiles[0]);
  }
  EXPECT_TRUE(create().keys()->empty());
}

TEST_F(TileStoreTest, OneWriterAtATime) {
  TileWriter writer = create();
  put(writer, small_tree().tiles[0]);
  for (auto* open : {&TileWriter::create, &TileWriter::resume}) {
    const auto second = open(path_, small_tree().manifest);
    ASSERT_FALSE(second.has_value());
    EXPECT_EQ(second.error().code, ErrorCode::kIo);
    EXPECT_NE(second.error().message.find("another program"), std::string::npos) << second.error().text();
  }
  EXPECT_EQ(writer.keys()->size(), 1U) << "the first goes on undisturbed";
}

TEST_F(TileStoreTest, FinishStopsWhenAskedAndCanBeRepeated) {
  TileWriter writer = create();
  TestTree tree = small_tree();
  for (auto& tile : tree.tiles) {
    tile.payload.resize(100000);
    put(writer, tile);
  }
  const StopFlag stop = true;
  const auto stopped = writer.finish(&stop);
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(stopped.error().code, ErrorCode::kStopped) << stopped.error().text();
  EXPECT_FALSE(fs::exists(path_));
  EXPECT_TRUE(fs::exists(TileWriter::building_path(path_)));
  EXPECT_TRUE(writer.finish().has_value());
}

TEST_F(TileStoreTest, AFinishedFileIsOnePlainFile) {
  test::write_tree(path_, small_tree());
  EXPECT_EQ(std::distance(fs::directory_iterator(dir_.path()), {}), 1) << "something is left over";
  const std::string bytes = test::read_file(path_);
  EXPECT_EQ(bytes.substr(18, 2), "\1\1") << "rollback journal, not WAL";
}

TEST_F(TileStoreTest, FinishReplacesAnOlderTree) {
  test::write_file(path_, "something old");
  test::write_tree(path_, small_tree());
  EXPECT_TRUE(TileStore::open(path_).has_value());
}

TEST_F(TileStoreTest, UnfinishedTreesAreRefused) {
  { TileWriter writer = create(); }
  const Error error = open_error(TileWriter::building_path(path_));
  EXPECT_EQ(error.code, ErrorCode::kBadData);
  EXPECT_NE(error.message.find("--resume"), std::string::npos);
}

TEST_F(TileStoreTest, MissingTiles) {
  test::write_tree(path_, small_tree());
  const auto store = TileStore::open(path_);
  const auto tile = store->read({2, 3, 3});
  ASSERT_FALSE(tile.has_value());
  EXPECT_EQ(tile.error().code, ErrorCode::kBadData);
  EXPECT_NE(tile.error().message.find("2/3/3"), std::string::npos);
}

TEST_F(TileStoreTest, ReadsFromSeveralThreads) {
  const TestTree& tree = small_tree();
  test::write_tree(path_, tree);
  const auto store = TileStore::open(path_);
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = 0; i < 100; ++i) {
        const StoredTile& expected = tree.tiles[(i * 7 + t) % tree.tiles.size()];
        const auto tile = store->read(expected.info.id);
        ASSERT_TRUE(tile.has_value());
        ASSERT_EQ(tile->payload, expected.payload);
      }
    });
  }
}

TEST_F(TileStoreTest, MissingFileAndDirectory) {
  EXPECT_EQ(open_error(dir_.file("none.tintree")).code, ErrorCode::kIo);
  EXPECT_EQ(open_error(dir_.path()).code, ErrorCode::kIo);
}

TEST_F(TileStoreTest, FilesThatAreNoTree) {
  std::string noise(50000, '\0');
  std::mt19937 random(3);
  for (char& c : noise) c = static_cast<char>(random());
  for (const std::string& content : {std::string(), std::string("a letter"), std::string(5000, 'x'), noise}) {
    test::write_file(path_, content);
    EXPECT_EQ(open_error(path_).code, ErrorCode::kBadData);
  }
}

TEST_F(TileStoreTest, NewerFormatsAreRefusedByName) {
  test::write_tree(path_, small_tree());
  std::string bytes = test::read_file(path_);
  bytes[63] = 3;
  test::write_file(path_, bytes);
  const Error error = open_error(path_);
  EXPECT_EQ(error.code, ErrorCode::kBadData);
  EXPECT_NE(error.message.find("version 3"), std::string::npos);
}

// What older programs can read says so: byte 63 is the format version.
TEST_F(TileStoreTest, OnlyTwoLevelsADoublingRaiseTheFormat) {
  for (const int levels : {1, 2}) {
    TestTree tree = small_tree();
    codec::TreeLayout& layout = tree.manifest.layout;
    layout.levels_per_doubling = levels;
    layout.leaf_level *= levels;
    layout.z_step_m.assign(static_cast<std::size_t>(layout.leaf_level) + 1, layout.z_step_m[0]);
    tree.tiles.resize(1);  // The root.
    test::write_tree(path_, tree);
    EXPECT_EQ(test::read_file(path_)[63], levels);
    const auto store = TileStore::open(path_);
    ASSERT_TRUE(store.has_value()) << store.error().text();
    EXPECT_EQ(store->manifest().layout.levels_per_doubling, levels);
    EXPECT_EQ(store->bounds().layout().leaf_level, layout.leaf_level);
  }
}

TEST_F(TileStoreTest, UnknownMethodsAreRefusedByName) {
  TestTree tree = small_tree();
  tree.manifest.method = "moss";
  test::write_tree(path_, tree);
  const auto store = TileStore::open(path_);
  ASSERT_TRUE(store.has_value());
  const auto mesh = store->read_mesh({});
  ASSERT_FALSE(mesh.has_value());
  EXPECT_NE(mesh.error().message.find("moss"), std::string::npos);
}

TEST_F(TileStoreTest, NoFolder) {
  for (const std::string& place : {dir_.file("none/t.tintree"), dir_.file("a_file/t.tintree")}) {
    test::write_file(dir_.file("a_file"), "x");
    const auto writer = TileWriter::create(place, small_tree().manifest);
    ASSERT_FALSE(writer.has_value());
    EXPECT_EQ(writer.error().code, ErrorCode::kIo);
    EXPECT_NE(writer.error().text().find(place), std::string::npos);
  }
}

TEST_F(TileStoreTest, GoalThatCannotBeReplaced) {
  fs::create_directories(path_ + "/occupied");
  TileWriter writer = create();
  for (const auto& tile : small_tree().tiles) put(writer, tile);
  const auto digest = writer.finish();
  ASSERT_FALSE(digest.has_value());
  EXPECT_EQ(digest.error().code, ErrorCode::kIo);
  EXPECT_TRUE(fs::exists(TileWriter::building_path(path_))) << "the work is lost";
}

}  // namespace
}  // namespace tintree::cache
