#include "render/chunk_pool.h"

#include <map>
#include <random>

#include <gtest/gtest.h>

namespace tintree::render {
namespace {

class ChunkPoolTest : public testing::Test {
 protected:
  std::size_t size_of(const ChunkPool& pool, std::optional<std::size_t> chunk) const {
    return chunk ? pool.chunks()[*chunk].size : 0;
  }
  std::vector<std::uint64_t> put_out_;
};

TEST_F(ChunkPoolTest, MakesChunksOfDoublingSizesUpToTheBudget) {
  ChunkPool pool(100, 10);
  EXPECT_EQ(size_of(pool, pool.take(1, 11, 1, put_out_)), 20U);
  EXPECT_EQ(size_of(pool, pool.take(2, 10, 1, put_out_)), 10U);
  EXPECT_EQ(size_of(pool, pool.take(3, 41, 1, put_out_)), 0U) << "80 bytes do not fit beside 30 in use";
  EXPECT_EQ(size_of(pool, pool.take(4, 21, 1, put_out_)), 40U);
  EXPECT_EQ(pool.bytes(), 70U);
  EXPECT_EQ(size_of(pool, pool.take(5, 101, 2, put_out_)), 0U) << "more than the budget";
  EXPECT_TRUE(put_out_.empty());
}

TEST_F(ChunkPoolTest, ReusesWhatIsEmpty) {
  ChunkPool pool(40, 10);
  const auto large = *pool.take(1, 35, 1, put_out_);
  pool.give_back(large);
  EXPECT_EQ(*pool.take(2, 5, 1, put_out_), large) << "no room is left for a tighter one";
  EXPECT_TRUE(put_out_.empty());
}

TEST_F(ChunkPoolTest, PutsOutTheOldestUnlessItIsMuchTooLarge) {
  ChunkPool pool(7, 1);
  const auto small = *pool.take(1, 1, 10, put_out_);
  const auto middle = *pool.take(2, 2, 8, put_out_);
  const auto large = *pool.take(3, 4, 5, put_out_);
  // Ages at frame 11: 1, 3, 6; for one unit they weigh 1, 1.5, 1.5.
  EXPECT_EQ(*pool.take(4, 1, 11, put_out_), middle);
  EXPECT_EQ(*pool.take(5, 1, 11, put_out_), large);
  EXPECT_EQ(*pool.take(6, 1, 11, put_out_), small);
  EXPECT_EQ(put_out_, (std::vector<std::uint64_t>{2, 3, 1}));
  EXPECT_FALSE(pool.take(7, 1, 11, put_out_).has_value()) << "all are used in this frame";
}

TEST_F(ChunkPoolTest, GivesUpSmallChunksForALargeOne) {
  ChunkPool pool(40, 10);
  for (std::uint64_t owner = 1; owner <= 4; ++owner) pool.take(owner, 10, owner, put_out_);
  EXPECT_EQ(size_of(pool, pool.take(5, 20, 5, put_out_)), 20U);
  EXPECT_EQ(put_out_, (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(pool.bytes(), 40U);
}

TEST_F(ChunkPoolTest, NeverHandsOutWhatIsInUse) {
  std::mt19937 random(4);
  ChunkPool pool(40000, 100);
  std::map<std::uint64_t, std::size_t> held;  // this frame's owners
  std::uint64_t owner = 0;
  for (std::uint64_t frame = 1; frame < 200; ++frame) {
    held.clear();
    for (int i = 0; i < 30; ++i) {
      const std::size_t size = 1 + random() % 5000;
      put_out_.clear();
      const auto chunk = pool.take(++owner, size, frame, put_out_);
      for (const std::uint64_t out : put_out_) EXPECT_FALSE(held.contains(out));
      EXPECT_LE(pool.bytes(), 40000U);
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
