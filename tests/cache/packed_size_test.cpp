#include "cache/packed_size.h"

#include <filesystem>
#include <random>

#include <gtest/gtest.h>
#include <sqlite3.h>

#include "tests/support/regular_tree.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::cache {
namespace {

/// Bytes of the file with pages of another size, as SQLite packs it.
std::uintmax_t bytes_with_pages(const std::string& tree, int page_bytes, const std::string& copy) {
  std::filesystem::remove(copy);
  sqlite3* db = nullptr;
  EXPECT_EQ(sqlite3_open(tree.c_str(), &db), SQLITE_OK);
  const std::string sql = "PRAGMA page_size = " + std::to_string(page_bytes) + "; VACUUM INTO '" + copy + "'";
  EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
  sqlite3_close(db);
  return std::filesystem::file_size(copy);
}

TEST(PackedSize, IsThatOfTheFileAndTheLeast) {
  const test::TempDir dir;
  test::write_raster(dir.file("dem.tif"), {.columns = 70, .rows = 60}, [](int c, int r) { return test::hills(c, r); });
  test::TestTree tree = test::make_regular_tree(dir.file("dem.tif"), {.tile_cells = 8});
  ASSERT_GT(tree.tiles.size(), 80U);
  std::mt19937 random(3);
  // Rows that share a page, that fill one, and that overflow into others.
  for (const std::size_t most : {10U, 100U, 400U, 1200U, 3000U, 9000U, 200000U}) {
    SCOPED_TRACE(most);
    PackedSize size;
    for (auto& tile : tree.tiles) {
      tile.payload.resize(1 + random() % most);
      size.add(tile.payload.size());
    }
    test::write_tree(dir.file("t.tintree"), tree);
    const auto bytes = static_cast<double>(std::filesystem::file_size(dir.file("t.tintree")));
    EXPECT_NEAR(static_cast<double>(size.bytes()), bytes, size.page_bytes() + 0.01 * bytes);
    for (const int page_bytes : {1024, 2048, 4096, 8192, 16384}) {
      const auto other = static_cast<double>(bytes_with_pages(dir.file("t.tintree"), page_bytes, dir.file("other")));
      if (page_bytes == size.page_bytes()) {
        EXPECT_EQ(bytes, other);
      }
      EXPECT_LT(bytes, 1024 + 1.01 * other) << "pages of " << page_bytes;
    }
  }
}

TEST(PackedSize, PagesGoByThePayloads) {
  const auto page_bytes = [](std::uint64_t payload_bytes) {
    PackedSize size;
    for (int i = 0; i < 10000; ++i) size.add(payload_bytes);
    return size.page_bytes();
  };
  EXPECT_GT(page_bytes(300), 1024);    // in 1024 bytes two rows would leave a quarter
  EXPECT_LT(page_bytes(9000), 16384);  // in 16384 bytes one would leave nearly half
}

}  // namespace
}  // namespace tintree::cache
