#include "cache/tile_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/tree_layout.h"

namespace tintree::cache {
namespace {

using codec::TileId;
using codec::TreeLayout;
using test::make_layout;

/// The root and, of every tile's possible children, each with a chance of `keep`; in key order.
std::vector<TileInfo> random_tiles(std::mt19937& random, const TreeLayout& layout, double keep) {
  std::uniform_real_distribution<> height(-5000, 9000);
  std::uniform_real_distribution<> error(0, 50);
  std::uniform_real_distribution<> dice(0, 1);
  std::vector<TileInfo> tiles(1);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const double z = height(random);
    TileInfo& t = tiles[i];
    t.z_min_m = z;
    t.z_max_m = z + error(random);
    t.error_m = error(random);
    t.border_error_m = error(random) / 2;
    const TileId id = t.id;
    if (id.level == layout.leaf_level) continue;
    for (int q = 0; q < layout.child_count(id.level); ++q) {
      const TileId child = layout.child(id, q);
      if (layout.cells(child).empty() || dice(random) > keep) continue;
      tiles.emplace_back();
      tiles.back().id = child;
    }
  }
  std::ranges::sort(tiles, {}, [](const TileInfo& t) { return t.id.key(); });
  return tiles;
}

/// Height range of a tile and of all that lies below it, found by looking at every tile.
std::pair<double, double> heights_below(const TreeLayout& layout, const std::vector<TileInfo>& tiles,
                                        const TileId& id) {
  std::pair range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const TileInfo& t : tiles) {
    if (t.id.level < id.level) continue;
    const int depth = layout.halvings(t.id.level) - layout.halvings(id.level);
    if (t.id.x >> depth != id.x || t.id.y >> depth != id.y) continue;
    range = {std::min(range.first, t.z_min_m), std::max(range.second, t.z_max_m)};
  }
  return range;
}

void expect_same(const TileBounds& a, const TileBounds& b) {
  ASSERT_EQ(a.nodes().size(), b.nodes().size());
  for (std::size_t i = 0; i < a.nodes().size(); ++i) {
    const TileNode& m = a.nodes()[i];
    const TileNode& n = b.nodes()[i];
    ASSERT_EQ(m.id, n.id) << "node " << i;
    ASSERT_EQ(m.child_mask, n.child_mask);
    ASSERT_EQ(m.first_child, n.first_child);
    ASSERT_EQ(m.z_min_m, n.z_min_m);
    ASSERT_EQ(m.z_max_m, n.z_max_m);
    ASSERT_EQ(m.lod_error_m, n.lod_error_m);
  }
}

/// What holds for every hierarchy that from_bytes() lets through.
void expect_tree(const TileBounds& bounds) {
  const auto nodes = bounds.nodes();
  ASSERT_FALSE(nodes.empty());
  ASSERT_EQ(nodes[0].id, TileId{});
  std::set<std::int64_t> seen;
  std::size_t children = 1;
  for (const TileNode& n : nodes) {
    ASSERT_TRUE(seen.insert(n.id.key()).second) << n.id.text() << " twice";
    ASSERT_LE(n.id.level, bounds.layout().leaf_level);
    ASSERT_FALSE(bounds.layout().cells(n.id).empty());
    ASSERT_FALSE(std::isnan(n.z_min_m) || std::isnan(n.z_max_m) || std::isnan(n.lod_error_m));
    std::size_t at = n.first_child;
    for (int q = 0; q < 4; ++q) {
      if ((n.child_mask >> q & 1) == 0) continue;
      ASSERT_LT(at, nodes.size());
      ASSERT_LT(q, bounds.layout().child_count(n.id.level));
      ASSERT_EQ(nodes[at++].id, bounds.layout().child(n.id, q));
      ++children;
    }
  }
  ASSERT_EQ(children, nodes.size());
  ASSERT_TRUE(std::ranges::is_sorted(nodes, {}, [](const TileNode& n) { return n.id.key(); }));
}

TEST(TileInfo, ErrorForTheCutCoversTheGapToTheNextLevel) {
  TileInfo t;
  t.error_m = 5;
  t.border_error_m = 2;
  EXPECT_EQ(t.lod_error_m(), 5);
  t.border_error_m = 3;
  EXPECT_EQ(t.lod_error_m(), 6);
}

TEST(TileBounds, SurvivesItsBytes) {
  std::mt19937 random(1);
  for (int i = 0; i < 60; ++i) {
    const TreeLayout layout = make_layout(2 + random() % 400, 2 + random() % 400, 8, 1 + i % 2);
    const auto tiles = random_tiles(random, layout, i % 3 == 0 ? 1 : 0.8);
    const TileBounds bounds(layout, tiles);
    const auto bytes = bounds.to_bytes();
    EXPECT_EQ(bytes.size(), 16 * tiles.size());
    const auto back = TileBounds::from_bytes(layout, bytes);
    ASSERT_TRUE(back.has_value()) << back.error().text();
    expect_same(*back, bounds);
    expect_tree(*back);
  }
}

TEST(TileBounds, FindsEveryTileAndNoOther) {
  std::mt19937 random(2);
  const TreeLayout layout = make_layout(300, 200, 8, 2);
  const auto tiles = random_tiles(random, layout, 0.7);
  const TileBounds bounds(layout, tiles);
  std::set<std::int64_t> there;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    EXPECT_EQ(bounds.find(tiles[i].id), static_cast<std::int64_t>(i));
    there.insert(tiles[i].id.key());
  }
  for (int level = 0; level <= layout.leaf_level; ++level) {
    for (std::uint32_t y = 0; y < layout.tiles_y(level); ++y) {
      for (std::uint32_t x = 0; x < layout.tiles_x(level); ++x) {
        const TileId id{level, x, y};
        if (!there.contains(id.key())) {
          EXPECT_EQ(bounds.find(id), -1);
        }
      }
    }
  }
}

TEST(TileBounds, FloatsNeverUnderstate) {
  std::mt19937 random(3);
  for (const int levels_per_doubling : {1, 2}) {
    const TreeLayout layout = make_layout(300, 300, 8, levels_per_doubling);
    const auto tiles = random_tiles(random, layout, 1);
    const TileBounds bounds(layout, tiles);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      const TileNode& n = bounds.nodes()[i];
      const auto [low, high] = heights_below(layout, tiles, tiles[i].id);
      EXPECT_LE(static_cast<double>(n.z_min_m), low);
      EXPECT_GE(static_cast<double>(n.z_max_m), high);
      EXPECT_GE(static_cast<double>(n.lod_error_m), tiles[i].lod_error_m());
      EXPECT_NEAR(n.z_min_m, low, 1e-3);
      EXPECT_NEAR(n.z_max_m, high, 1e-3);
      EXPECT_NEAR(n.lod_error_m, tiles[i].lod_error_m(), 1e-4);
    }
  }
}

TEST(TileBounds, BoxIsCutToTheRaster) {
  const TreeLayout layout = make_layout(21, 11, 8);  // 20 x 10 cells
  TileInfo root;
  root.z_min_m = -1;
  root.z_max_m = 2;
  const TileBounds bounds(layout, std::vector{root});
  const Box box = bounds.box(bounds.nodes()[0]);
  EXPECT_EQ(box.min, (std::array<double, 3>{0, -10 * 28.25, -1}));
  EXPECT_EQ(box.max, (std::array<double, 3>{20 * 30.5, 0, 2}));
}

TEST(TileBounds, BoxHoldsATurnedTile) {
  TreeLayout layout = make_layout(21, 11, 8);
  layout.dx_m = 10;
  layout.dy_m = 20;
  layout.axes = {{0.6, 0.8}, {0.8, -0.6}};
  TileInfo root;
  const TileBounds bounds(layout, std::vector{root});
  const Box box = bounds.box(bounds.nodes()[0]);
  // The corners lie at (0, 0), (120, 160), (160, -120) and (280, 40).
  EXPECT_NEAR(box.min[0], 0, 1e-9);
  EXPECT_NEAR(box.min[1], -120, 1e-9);
  EXPECT_NEAR(box.max[0], 280, 1e-9);
  EXPECT_NEAR(box.max[1], 160, 1e-9);
}

TEST(TileBounds, EveryTruncationIsRefused) {
  std::mt19937 random(4);
  const TreeLayout layout = make_layout(100, 100, 8);
  const auto bytes = TileBounds(layout, random_tiles(random, layout, 0.9)).to_bytes();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(TileBounds::from_bytes(layout, cut).has_value()) << size;
  }
  auto longer = bytes;
  longer.resize(bytes.size() + 16);
  EXPECT_FALSE(TileBounds::from_bytes(layout, longer).has_value());
}

TEST(TileBounds, NonsenseIsRefused) {
  const TreeLayout layout = make_layout(9, 9, 8);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto record = [](float low, float high, float error, int mask) {
    std::vector<std::byte> out(16);
    std::memcpy(out.data(), &low, 4);
    std::memcpy(out.data() + 4, &high, 4);
    std::memcpy(out.data() + 8, &error, 4);
    out[12] = static_cast<std::byte>(mask);
    return out;
  };
  EXPECT_TRUE(TileBounds::from_bytes(layout, record(1, 2, 3, 0)).has_value());
  EXPECT_FALSE(TileBounds::from_bytes(layout, record(2, 1, 3, 0)).has_value());
  EXPECT_FALSE(TileBounds::from_bytes(layout, record(nan, 1, 3, 0)).has_value());
  EXPECT_FALSE(TileBounds::from_bytes(layout, record(0, nan, 3, 0)).has_value());
  EXPECT_FALSE(TileBounds::from_bytes(layout, record(0, 1, nan, 0)).has_value());
  EXPECT_FALSE(TileBounds::from_bytes(layout, record(0, 1, -1, 0)).has_value());
  EXPECT_FALSE(TileBounds::from_bytes(layout, record(0, 1, 1, 1)).has_value()) << "a child below the leaves";
  EXPECT_FALSE(TileBounds::from_bytes(layout, record(0, 1, 1, 16)).has_value());
}

TEST(TileBounds, DamageIsRefusedOrStillATree) {
  std::mt19937 random(6);
  const std::array layouts{make_layout(150, 90, 8), make_layout(150, 90, 8, 2)};
  std::array<std::vector<std::byte>, 2> whole;
  for (std::size_t k = 0; k < 2; ++k)
    whole[k] = TileBounds(layouts[k], random_tiles(random, layouts[k], 0.9)).to_bytes();
  for (int i = 0; i < 20000; ++i) {
    const std::size_t k = static_cast<std::size_t>(i) / 2 % 2;
    const TreeLayout& layout = layouts[k];
    const std::vector<std::byte>& bytes = whole[k];
    auto damaged = bytes;
    // Masks are where damage matters most.
    const std::size_t record = random() % (bytes.size() / 16);
    damaged[16 * record + (i % 2 == 0 ? 12 : random() % 16)] = static_cast<std::byte>(random());
    if (const auto bounds = TileBounds::from_bytes(layout, damaged)) expect_tree(*bounds);
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace tintree::cache
