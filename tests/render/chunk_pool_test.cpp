#include "render/chunk_pool.h"

#include <map>
#include <random>

#include <gtest/gtest.h>

namespace tintree::render {
namespace {

TEST(ChunkPool, HasDoublingSizesInEqualShares) {
  const ChunkPool pool(1200, 10, 75);
  std::map<std::size_t, std::size_t> bytes;
  std::size_t end = 0;
  for (const ChunkPool::Chunk& c : pool.chunks()) {
    EXPECT_EQ(c.begin, end) << "chunks overlap, or leave gaps";
    end += c.size;
    bytes[c.size] += c.size;
  }
  EXPECT_EQ(bytes, (std::map<std::size_t, std::size_t>{{10, 300}, {20, 300}, {40, 280}, {80, 240}}));
  EXPECT_EQ(pool.bytes(), end);
}

TEST(ChunkPool, TakesTheTightestEmptyChunk) {
  ChunkPool pool(400, 10, 80);
  EXPECT_EQ(pool.chunks()[*pool.take(1, 11, 1)].size, 20U);
  EXPECT_EQ(pool.chunks()[*pool.take(2, 10, 1)].size, 10U);
  EXPECT_EQ(pool.chunks()[*pool.take(3, 80, 1)].size, 80U);
  EXPECT_FALSE(pool.take(4, 80, 1).has_value()) << "there is one, and this frame uses it";
  EXPECT_FALSE(pool.take(5, 81, 2).has_value()) << "none is so large";
}

TEST(ChunkPool, PutsOutTheOldestUnlessItIsMuchTooLarge) {
  ChunkPool known(3, 1, 4);
  const auto small = *known.take(1, 1, 10);
  const auto middle = *known.take(2, 2, 8);
  const auto large = *known.take(3, 4, 5);
  // Ages at frame 11: 1, 3, 6; for one unit they weigh 1, 1.5, 1.5.
  EXPECT_EQ(*known.take(4, 1, 11), middle);
  EXPECT_EQ(known.chunks()[middle].owner, 4U);
  // 1 and 1.5 are left.
  EXPECT_EQ(*known.take(5, 1, 11), large);
  EXPECT_EQ(*known.take(6, 1, 11), small);
  EXPECT_FALSE(known.take(7, 1, 11).has_value()) << "all are used in this frame";
}

TEST(ChunkPool, NeverHandsOutWhatIsInUse) {
  std::mt19937 random(4);
  ChunkPool pool(100000, 100, 5000);
  std::map<std::uint64_t, std::size_t> held;  // this frame's owners
  std::uint64_t owner = 0;
  for (std::uint64_t frame = 1; frame < 200; ++frame) {
    held.clear();
    for (int i = 0; i < 30; ++i) {
      const std::size_t size = 1 + random() % 5000;
      const auto chunk = pool.take(++owner, size, frame);
      if (!chunk) continue;
      EXPECT_GE(pool.chunks()[*chunk].size, size);
      for (const auto& [other, at] : held) EXPECT_NE(at, *chunk) << other;
      held[owner] = *chunk;
    }
    EXPECT_FALSE(held.empty());
  }
}

}  // namespace
}  // namespace tintree::render
