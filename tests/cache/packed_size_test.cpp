#include "cache/packed_size.h"

#include <filesystem>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/regular_tree.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::cache {
namespace {

TEST(PackedSize, IsThatOfTheFile) {
  const test::TempDir dir;
  test::write_raster(dir.file("dem.tif"), {.columns = 70, .rows = 60}, [](int c, int r) { return test::hills(c, r); });
  test::TestTree tree = test::make_regular_tree(dir.file("dem.tif"), {.tile_cells = 8});
  ASSERT_GT(tree.tiles.size(), 80U);
  std::mt19937 random(3);
  // Rows that share a page, that fill one, and that overflow into others.
  for (const std::size_t most : {10U, 100U, 3000U, 9000U, 20000U, 200000U}) {
    SCOPED_TRACE(most);
    PackedSize size;
    for (auto& tile : tree.tiles) {
      tile.payload.resize(1 + random() % most);
      size.add(tile.payload.size());
    }
    test::write_tree(dir.file("t.tintree"), tree);
    const auto bytes = static_cast<double>(std::filesystem::file_size(dir.file("t.tintree")));
    // To the page where there are but a few.
    EXPECT_NEAR(static_cast<double>(size.bytes()), bytes, 0.02 * bytes);
  }
}

}  // namespace
}  // namespace tintree::cache
