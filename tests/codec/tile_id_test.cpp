#include "codec/tile_id.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tintree::codec {
namespace {

TileId random_id(std::mt19937& random) {
  const int level = static_cast<int>(random() % (kMaxLevel + 1));
  const std::uint32_t mask = (std::uint32_t{1} << level) - 1;
  return {level, static_cast<std::uint32_t>(random()) & mask, static_cast<std::uint32_t>(random()) & mask};
}

/// The Morton number from its definition, a bit at a time.
std::uint64_t slow_morton(const TileId& id) {
  std::uint64_t out = 0;
  for (int i = 0; i < 32; ++i) {
    out |= std::uint64_t{id.x >> i & 1U} << (2 * i);
    out |= std::uint64_t{id.y >> i & 1U} << (2 * i + 1);
  }
  return out;
}

TEST(TileId, KeyAndBack) {
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    const TileId id = random_id(random);
    EXPECT_EQ(TileId::from_key(id.key()), id) << id.text();
    EXPECT_EQ(id.morton(), slow_morton(id)) << id.text();
    EXPECT_GE(id.key(), 0);
  }
}

TEST(TileId, KeysOfTheCorners) {
  for (int level = 0; level <= kMaxLevel; ++level) {
    const std::uint32_t last = (std::uint32_t{1} << level) - 1;
    for (const TileId& id :
         {TileId{level, 0, 0}, TileId{level, last, 0}, TileId{level, 0, last}, TileId{level, last, last}}) {
      EXPECT_EQ(TileId::from_key(id.key()), id) << id.text();
    }
  }
  EXPECT_EQ((TileId{0, 0, 0}).key(), 0);
  EXPECT_EQ((TileId{1, 1, 0}).key(), (std::int64_t{1} << 58) + 1);
  EXPECT_EQ((TileId{1, 0, 1}).key(), (std::int64_t{1} << 58) + 2);
}

TEST(TileId, KeysGoLevelByLevelAlongTheZOrder) {
  std::mt19937 random(2);
  for (int i = 0; i < 20000; ++i) {
    const TileId a = random_id(random);
    const TileId b = random_id(random);
    const bool before = a.level != b.level ? a.level < b.level : slow_morton(a) < slow_morton(b);
    EXPECT_EQ(a.key() < b.key(), before) << a.text() << " and " << b.text();
  }
}

TEST(TileId, SaysItsName) { EXPECT_EQ((TileId{3, 5, 2}).text(), "3/5/2"); }

}  // namespace
}  // namespace tintree::codec
