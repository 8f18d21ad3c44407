#include "cache/height_blocks.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <malloc.h>

#include <gtest/gtest.h>

#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::cache {
namespace {

using test::HeightFunction;
using test::RasterSpec;

constexpr std::uint64_t kPlenty = std::uint64_t{1} << 30;

class HeightBlocksTest : public testing::Test {
 protected:
  std::shared_ptr<const RasterSource> open(const RasterSpec& spec, const HeightFunction& height) {
    test::write_raster(dir_.file("dem.tif"), spec, height);
    auto source = RasterSource::open(dir_.file("dem.tif"));
    if (!source) throw std::runtime_error(source.error().text());
    return std::make_shared<const RasterSource>(std::move(*source));
  }

  test::TempDir dir_;
};

/// Compares a block with what the source says, sample by sample.
void expect_block(const RasterSource& source, const HeightBlock& block, std::int64_t bx, std::int64_t by,
                  double tolerance) {
  ASSERT_EQ(block.column0, bx * kBlockCells);
  ASSERT_EQ(block.row0, by * kBlockCells);
  ASSERT_EQ(block.heights.size(), std::size_t{kBlockStride} * kBlockSamples);
  std::vector<double> direct(std::size_t{kBlockSamples} * kBlockSamples);
  ASSERT_TRUE(source.read(block.column0, block.row0, kBlockSamples, kBlockSamples, direct.data()).has_value());
  bool all_valid = true;
  for (int j = 0; j < kBlockSamples; ++j) {
    for (int i = 0; i < kBlockStride; ++i) {
      const float stored = block.row(j)[i];
      if (i >= kBlockSamples) {
        ASSERT_TRUE(std::isnan(stored)) << "padding of row " << j;
        continue;
      }
      const double truth = direct[static_cast<std::size_t>(j * kBlockSamples + i)];
      if (std::isnan(truth)) {
        all_valid = false;
        ASSERT_TRUE(std::isnan(stored)) << i << ", " << j;
      } else {
        ASSERT_NEAR(block.base_m + static_cast<double>(stored), truth, tolerance) << i << ", " << j;
      }
    }
  }
  EXPECT_EQ(block.all_valid, all_valid);
}

TEST_F(HeightBlocksTest, BlocksEqualDirectReadsExactlyOnIntegers) {
  const auto source = open({.columns = 600, .rows = 530, .type = test::SampleType::kInt16}, [](int c, int r) {
    if (c > 300 && c < 340 && r > 100 && r < 300) return test::kMissing;
    return std::round(8000 * std::sin(c * 0.01) * std::cos(r * 0.013));
  });
  HeightBlocks blocks(source, kPlenty);
  EXPECT_EQ(blocks.blocks_x(), 3);
  EXPECT_EQ(blocks.blocks_y(), 3);
  for (std::int64_t by = 0; by < 3; ++by) {
    for (std::int64_t bx = 0; bx < 3; ++bx) {
      const auto block = blocks.get(bx, by);
      ASSERT_TRUE(block.has_value());
      expect_block(*source, **block, bx, by, 0);
    }
  }
}

TEST_F(HeightBlocksTest, FractionsAreRoundedToFloatAroundTheBase) {
  const auto source =
      open({.columns = 300, .rows = 260}, [](int c, int r) { return 4000 + test::hills(c, r, 100) / 3; });
  HeightBlocks blocks(source, kPlenty);
  for (const std::int64_t bx : {0, 1}) {
    const auto block = blocks.get(bx, 0);
    ASSERT_TRUE(block.has_value());
    expect_block(*source, **block, bx, 0, 64 * std::ldexp(1.0, -24));
  }
}

TEST_F(HeightBlocksTest, AsManyBlocksAsCellsNeed) {
  for (const auto& [samples, count] : {std::pair{2, 1}, {256, 1}, {257, 1}, {258, 2}, {513, 2}, {514, 3}}) {
    const HeightBlocks blocks(open({.columns = samples, .rows = 2}, [](int, int) { return 1.0; }), kPlenty);
    EXPECT_EQ(blocks.blocks_x(), count) << samples;
    EXPECT_EQ(blocks.blocks_y(), 1);
  }
}

TEST_F(HeightBlocksTest, AllMissingIsAllNaN) {
  const auto source = open({.columns = 300, .rows = 300}, [](int, int) { return test::kMissing; });
  HeightBlocks blocks(source, kPlenty);
  const auto block = blocks.get(0, 0);
  ASSERT_TRUE(block.has_value());
  EXPECT_TRUE(std::isfinite((*block)->base_m));
  expect_block(*source, **block, 0, 0, 0);
}

TEST_F(HeightBlocksTest, CacheKeepsWhatFitsAndNoMore) {
  const auto source =
      open({.columns = 2100, .rows = 1100, .type = test::SampleType::kInt16}, [](int c, int r) { return c ^ r; });
  const std::uint64_t block_bytes = sizeof(float) * kBlockStride * kBlockSamples;
  HeightBlocks blocks(source, 10 * block_bytes);
  std::vector<std::weak_ptr<const HeightBlock>> seen;
  const auto alive = [&seen] { return std::ranges::count_if(seen, [](const auto& b) { return !b.expired(); }); };
  for (std::int64_t by = 0; by < blocks.blocks_y(); ++by) {
    for (std::int64_t bx = 0; bx < blocks.blocks_x(); ++bx) {
      const auto block = blocks.get(bx, by);
      ASSERT_TRUE(block.has_value());
      seen.push_back(*block);
    }
  }
  EXPECT_LE(alive(), 10);
  EXPECT_GE(alive(), 8);

  const auto kept = blocks.get(0, 0);
  ASSERT_TRUE(kept.has_value());
  EXPECT_EQ(kept->get(), blocks.get(0, 0)->get()) << "a cached block is read again";
  for (std::int64_t bx = 0; bx < blocks.blocks_x(); ++bx) {
    EXPECT_TRUE(blocks.get(bx, 1).has_value());
    EXPECT_EQ(kept->get(), blocks.get(0, 0)->get()) << "a block in use was thrown out before older ones";
  }
}

TEST_F(HeightBlocksTest, BlocksThatCallersHoldCount) {
  const auto source =
      open({.columns = 2100, .rows = 1100, .type = test::SampleType::kInt16}, [](int c, int r) { return c ^ r; });
  HeightBlocks blocks(source, 11 * sizeof(float) * kBlockStride * kBlockSamples);
  std::vector<std::shared_ptr<const HeightBlock>> held;
  for (std::int64_t bx = 0; bx < 7; ++bx) held.push_back(blocks.get(bx, 0).value());
  std::vector<std::weak_ptr<const HeightBlock>> seen(held.begin(), held.end());
  for (std::int64_t by = 1; by < blocks.blocks_y(); ++by) {
    for (std::int64_t bx = 0; bx < blocks.blocks_x(); ++bx) seen.push_back(blocks.get(bx, by).value());
  }
  EXPECT_LE(std::ranges::count_if(seen, [](const auto& b) { return !b.expired(); }), 11);
  EXPECT_EQ(blocks.get(0, 0).value(), held.front()) << "what is held is kept, not read again";

  // More than there is room for: all of it, and no more than the cache again once it is let go.
  for (std::int64_t by = 1; by < 3; ++by) {
    for (std::int64_t bx = 0; bx < blocks.blocks_x(); ++bx) held.push_back(blocks.get(bx, by).value());
  }
  EXPECT_GT(blocks.cached_bytes(), 11 * sizeof(float) * kBlockStride * kBlockSamples);
  held.clear();
  EXPECT_TRUE(blocks.get(0, 4).has_value());
  EXPECT_LE(blocks.cached_bytes(), 11 * sizeof(float) * kBlockStride * kBlockSamples);
}

TEST_F(HeightBlocksTest, BlocksDoNotLieInTheHolesOfTheHeap) {
  const auto source =
      open({.columns = 1100, .rows = 1100, .type = test::SampleType::kInt16}, [](int c, int r) { return c ^ r; });
  HeightBlocks blocks(source, kPlenty);
  std::vector<double> all(std::size_t{1100} * 1100);
  ASSERT_TRUE(source->read(0, 0, 1100, 1100, all.data()).has_value());  // GDAL's own blocks are there from now on
  std::vector<std::shared_ptr<const HeightBlock>> held;
  {
    // Once freed, these leave room in the heap for all blocks; what keeps it from going back comes after them.
    std::vector<std::unique_ptr<char[]>> gone;
    for (int i = 0; i < 200; ++i) gone.push_back(std::make_unique<char[]>(100'000));
    held.reserve(16);
  }
  const auto in_heap = [] { return ::mallinfo2().uordblks; };
  const std::size_t before = in_heap();
  for (std::int64_t by = 0; by < 4; ++by) {
    for (std::int64_t bx = 0; bx < 4; ++bx) {
      const auto block = blocks.get(bx, by);
      ASSERT_TRUE(block.has_value());
      held.push_back(*block);
    }
  }
  EXPECT_LT(in_heap(), before + sizeof(float) * kBlockStride * kBlockSamples);
}

TEST_F(HeightBlocksTest, StreamVisitsEveryBlockOnceInOrder) {
  const auto source =
      open({.columns = 700, .rows = 600}, [](int c, int r) { return c % 97 == 5 ? test::kMissing : c + r; });
  HeightBlocks blocks(source, 1);
  std::vector<std::pair<std::int64_t, std::int64_t>> order;
  const auto done = blocks.stream([&](std::int64_t bx, std::int64_t by, const auto& block) {
    order.emplace_back(by, bx);
    expect_block(*source, *block, bx, by, 0);
    return true;
  });
  ASSERT_TRUE(done.has_value());
  ASSERT_EQ(order.size(), 9U);
  EXPECT_TRUE(std::ranges::is_sorted(order));
  EXPECT_EQ(std::ranges::adjacent_find(order), order.end());
}

TEST_F(HeightBlocksTest, StreamCutsAWideRasterIntoBands) {
  const int columns = 70 * kBlockCells + 40;
  const auto source = open({.columns = columns, .rows = 3, .type = test::SampleType::kInt16},
                           [](int c, int r) { return c % 30000 + r; });
  HeightBlocks blocks(source, kPlenty);
  std::int64_t next = 0;
  const auto done = blocks.stream([&](std::int64_t bx, std::int64_t by, const auto& block) {
    EXPECT_EQ(bx, next++);
    EXPECT_EQ(by, 0);
    if (bx % 9 == 0 || bx == 63 || bx == 64) expect_block(*source, *block, bx, by, 0);
    return true;
  });
  ASSERT_TRUE(done.has_value());
  EXPECT_EQ(next, 71);
}

TEST_F(HeightBlocksTest, StreamStopsWhenToldTo) {
  const auto source = open({.columns = 700, .rows = 600}, [](int c, int) { return c; });
  HeightBlocks blocks(source, kPlenty);
  int visits = 0;
  ASSERT_TRUE(blocks.stream([&](auto, auto, const auto&) { return ++visits < 4; }).has_value());
  EXPECT_EQ(visits, 4);
}

TEST_F(HeightBlocksTest, RoundsByAShareOfTheRangeHoweverNarrow) {
  for (const double range_m : {0.0, 1e-9, 3e-6, 1e-3, 0.7, 1.0, 40.0, 5e5}) {
    for (const double from_m : {0.7, -0.3, 1234.6, -1e6}) {
      SCOPED_TRACE(testing::Message() << range_m << " from " << from_m);
      const auto source = open({.columns = 60, .rows = 50},
                               [&](int c, int r) { return from_m + range_m * (0.5 + test::hills(c, r, 0.5)); });
      HeightBlocks blocks(source, kPlenty);
      const auto block = blocks.get(0, 0);
      ASSERT_TRUE(block.has_value());
      expect_block(*source, **block, 0, 0, range_m * 0x1p-23 + 1e-15 * std::abs(from_m));
    }
  }
}

TEST_F(HeightBlocksTest, SeveralThreadsShareTheCache) {
  const auto source = open({.columns = 1300, .rows = 1300}, [](int c, int r) { return c + 2 * r; });
  HeightBlocks blocks(source, 6 * sizeof(float) * kBlockStride * kBlockSamples);
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < 4; ++t) {
    threads.emplace_back([&blocks, t] {
      for (unsigned i = 0; i < 60; ++i) {
        const auto bx = static_cast<std::int64_t>((i * 7 + t) % 6);
        const auto by = static_cast<std::int64_t>((i * 3 + 5 * t) % 6);
        const auto block = blocks.get(bx, by);
        ASSERT_TRUE(block.has_value());
        ASSERT_EQ((*block)->base_m + static_cast<double>((*block)->row(10)[10]),
                  static_cast<double>(bx * kBlockCells + 10 + 2 * (by * kBlockCells + 10)));
      }
    });
  }
}

}  // namespace
}  // namespace tintree::cache
