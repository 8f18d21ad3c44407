#include "codec/scalar_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "codec/bit_pack.h"
#include "codec/grid_frame.h"
#include "codec/index_coder.h"
#include "codec/scalar_grid.h"
#include "tests/codec/random_mesh.h"

namespace tintree::codec {
namespace {

using test::triangle_set;

const ScalarCodec kCodec;

void halve(std::mt19937& random, std::int32_t from, std::int32_t piece, std::int32_t length, unsigned chance,
           std::vector<std::int32_t>& places) {
  if (from >= length) return;
  if (piece > 1 && random() % 4 < chance) {
    halve(random, from, piece / 2, length, chance, places);
    halve(random, from + piece / 2, piece / 2, length, chance, places);
  } else {
    places.push_back(std::min(from + piece, length));
  }
}

/// A tile of any size and stride, its sides halved at random.
ScalarTile random_tile(std::mt19937& random) {
  ScalarTile tile;
  ScalarGrid& g = tile.grid;
  g.width = 2 + static_cast<std::int32_t>(random() % 40);
  g.height = 2 + static_cast<std::int32_t>(random() % 40);
  while (random() % 3 != 0 && 2 * g.stride < std::min(g.width, g.height)) g.stride *= 2;
  for (int side = 0; side < 4; ++side) {
    auto& places = g.sides[static_cast<std::size_t>(side)];
    places.push_back(0);
    halve(random, 0, 64, g.length(side), 1 + static_cast<unsigned>(random() % 3), places);
  }
  tile.xy_shift = static_cast<int>(random() % 33) - 3;
  tile.z_offset = static_cast<std::int64_t>(random()) - (std::int64_t{1} << 31);
  const std::int32_t step = 1 + static_cast<std::int32_t>(random() % 9);
  const auto levels = static_cast<std::int32_t>(1 + random() % (random() % 2 == 0 ? 4 : 3000));
  for (std::size_t i = 0; i < g.vertex_count(); ++i) {
    const auto level = static_cast<std::int32_t>(random()) & 0xffff;
    tile.z.push_back(i < g.border_count() ? level : level % levels * step);
  }
  return tile;
}

/// One of stride 1 that lacks vertices, though none near a longer edge of a side.
ScalarTile random_holed_tile(std::mt19937& random) {
  ScalarTile tile;
  do tile = random_tile(random);
  while (tile.grid.stride != 1);
  ScalarGrid& g = tile.grid;
  // Longer edges in the first half of the north side, and holes in the south.
  for (const int side : {ScalarGrid::kEast, ScalarGrid::kSouth, ScalarGrid::kWest}) {
    auto& places = g.sides[static_cast<std::size_t>(side)];
    places.clear();
    for (std::int32_t at = 0; at <= g.length(side); ++at) places.push_back(at);
  }
  tile.z.resize(g.vertex_count());
  for (std::int32_t& z : tile.z) z = static_cast<std::int32_t>(random() % 5000);
  const std::vector<GridVertex> places = g.places();
  const auto chance = 1 + random() % 90;
  for (const GridVertex& p : places) tile.missing.push_back(p.y > 1 && random() % 100 < chance);
  return tile;
}

void expect_round_trip(const TileMesh& mesh) {
  const auto bytes = kCodec.encode(mesh);
  ASSERT_TRUE(bytes.has_value()) << bytes.error().text();
  EXPECT_EQ(*bytes, *kCodec.encode(mesh)) << "encoding is not deterministic";
  const auto back = kCodec.decode(*bytes);
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->xy_shift, mesh.xy_shift);
  EXPECT_EQ(back->z_offset, mesh.z_offset);
  EXPECT_EQ(back->vertices.size(), mesh.vertices.size());
  EXPECT_EQ(triangle_set(*back), triangle_set(mesh));
}

/// Twice the area that the triangles cover, and that all are turned the right way.
std::int64_t doubled_cover(const TileMesh& mesh) {
  std::int64_t sum = 0;
  for (const Triangle& t : mesh.triangles) {
    const std::int64_t area = doubled_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
    EXPECT_GT(area, 0);
    sum += area;
  }
  return sum;
}

TEST(ScalarGrid, CoversItsRectangleOnce) {
  std::mt19937 random(1);
  for (int i = 0; i < 300 && !testing::Test::HasFailure(); ++i) {
    const ScalarTile tile = random_tile(random);
    const TileMesh mesh = tile.mesh();
    const ScalarGrid& g = tile.grid;
    SCOPED_TRACE(testing::Message() << g.width << " x " << g.height << ", stride " << g.stride);
    EXPECT_EQ(doubled_cover(mesh), 2 * std::int64_t{g.width} * g.height);
    // A disk without a vertex inside an edge: Euler's formula gives the triangles.
    EXPECT_EQ(mesh.triangles.size(), 2 * mesh.vertices.size() - 2 - g.border_count());
  }
}

TEST(ScalarGrid, OfEverySampleIsTheSurfacesOwnTriangulation) {
  ScalarGrid g{.width = 7, .height = 5, .stride = 1, .sides = {}};
  for (int side = 0; side < 4; ++side) {
    for (std::int32_t at = 0; at <= g.length(side); ++at) g.sides[static_cast<std::size_t>(side)].push_back(at);
  }
  const std::vector<GridVertex> places = g.places();
  ASSERT_EQ(places.size(), 48U);
  ASSERT_EQ(g.triangles().size(), 70U);
  for (const Triangle& t : g.triangles()) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t dx = places[t[(k + 1) % 3]].x - places[t[k]].x;
      const std::int32_t dy = places[t[(k + 1) % 3]].y - places[t[k]].y;
      EXPECT_TRUE(std::abs(dx) <= 1 && std::abs(dy) <= 1 && dx * dy >= 0) << dx << ", " << dy;
    }
  }
}

TEST(ScalarCodec, KeepsRandomTiles) {
  std::mt19937 random(2);
  for (int i = 0; i < 400 && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE("tile " + std::to_string(i));
    expect_round_trip(random_tile(random).mesh());
  }
}

TEST(ScalarCodec, KeepsTilesWithHoles) {
  std::mt19937 random(3);
  int pinched = 0;
  for (int i = 0; i < 300 && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE("tile " + std::to_string(i));
    const TileMesh mesh = random_holed_tile(random).mesh();
    if (mesh.triangles.empty()) continue;
    auto places = mesh.vertices;
    std::ranges::sort(places, {}, [](const GridVertex& v) { return std::pair{v.x, v.y}; });
    pinched += std::ranges::adjacent_find(places) != places.end() ? 1 : 0;
    expect_round_trip(mesh);
  }
  EXPECT_GT(pinched, 10) << "the test has few vertices where fans meet";
}

TEST(ScalarCodec, KeepsAStripOneCellWide) {
  for (const bool wide : {false, true}) {
    ScalarTile tile;
    tile.grid.width = wide ? 9 : 1;
    tile.grid.height = wide ? 1 : 9;
    for (int side = 0; side < 4; ++side) {
      for (std::int32_t at = 0; at <= tile.grid.length(side); ++at)
        tile.grid.sides[static_cast<std::size_t>(side)].push_back(at);
    }
    for (std::size_t i = 0; i < tile.grid.vertex_count(); ++i) tile.z.push_back(static_cast<std::int32_t>(i * i));
    EXPECT_EQ(doubled_cover(tile.mesh()), 18);
    expect_round_trip(tile.mesh());
  }
}

TEST(ScalarCodec, RefusesWhatIsNoGrid) {
  TileMesh lone;
  lone.vertices = {{0, 0, 1}, {2, 3, 2}, {5, 1, 3}};
  lone.triangles = {{0, 1, 2}};
  EXPECT_FALSE(kCodec.encode(lone).has_value());
  std::mt19937 random(4);
  TileMesh flipped = random_tile(random).mesh();
  flipped.triangles.pop_back();
  EXPECT_FALSE(kCodec.encode(flipped).has_value());
}

TEST(ScalarCodec, FewHeightsTakeATableAndManyAStep) {
  std::mt19937 random(5);
  std::vector<std::int32_t> two;
  std::vector<std::int32_t> three;
  std::vector<std::int32_t> even;
  for (int i = 0; i < 4000; ++i) {
    two.push_back(random() % 2 == 0 ? 17 : 4000000);
    three.push_back(std::array{5, 1000, 3000001}[random() % 3]);
    even.push_back(9 + 14 * static_cast<std::int32_t>(random() % 100));
  }
  const auto size = [](const std::vector<std::int32_t>& heights) {
    std::vector<std::byte> bytes;
    put_quantized(bytes, heights);
    std::vector<std::int32_t> back(heights.size());
    EXPECT_TRUE(take_quantized(bytes, back));
    EXPECT_EQ(back, heights);
    return static_cast<double>(bytes.size());
  };
  EXPECT_LT(size(two), 4000.0 / 8 + 16);                          // one bit each
  EXPECT_LT(size(three), 4000 * std::log2(3.0) / 8 * 1.01 + 16);  // no power of two
  EXPECT_LT(size(even), 4000 * std::log2(100.0) / 8 * 1.01 + 16);
}

TEST(DigitBlock, IsNeverWorseThanWholeBitsAndHoldsItsDigits) {
  for (std::uint64_t levels = 2; levels < 70000; levels += 1 + levels / 50) {
    const DigitBlock block(levels);
    const double log = std::log2(static_cast<double>(levels));
    EXPECT_LE(block.bits, 63);
    EXPECT_GE(block.bits, block.digits * log - 1e-9) << levels;
    EXPECT_LE(block.bits, block.digits * std::ceil(log)) << levels;
    EXPECT_LT(block.bits, block.digits * log + 1) << levels;
  }
}

TEST(ScalarCodec, DequantizationIsOneMatrix) {
  TreeLayout layout;
  layout.columns = layout.rows = 513;
  layout.leaf_level = 1;
  layout.dx_m = 30;
  layout.dy_m = 25;
  layout.z_step_m = {2, 1};
  std::mt19937 random(6);
  const std::array<double, 3> eye{100, -200, 50};
  for (int i = 0; i < 50; ++i) {
    ScalarTile tile = random_tile(random);
    tile.xy_shift = 1;
    const std::int32_t step = 7;
    const std::int32_t offset = 1000;
    const std::size_t first = tile.grid.border_count();
    std::vector<std::int32_t> indices(tile.z.size());
    for (std::size_t v = first; v < tile.z.size(); ++v) {
      indices[v] = static_cast<std::int32_t>(random() % 64);
      tile.z[v] = offset + step * indices[v];
    }
    const TileMesh mesh = tile.mesh();
    const GridFrame frame(layout, {1, 1, 1}, mesh);
    const auto m = frame.matrix(eye);
    const auto q = inverse_quantization(tile.grid.stride, step, offset);
    std::array<double, 16> both{};
    for (std::size_t c = 0; c < 4; ++c) {
      for (std::size_t r = 0; r < 4; ++r) {
        for (std::size_t k = 0; k < 4; ++k) both[4 * c + r] += m[4 * k + r] * q[4 * c + k];
      }
    }
    for (std::size_t v = first; v < tile.z.size(); ++v) {
      const auto n = static_cast<std::int64_t>(v - first);
      const std::array<double, 4> index{static_cast<double>(n % tile.grid.columns()),
                                        static_cast<double>(n / tile.grid.columns()), static_cast<double>(indices[v]),
                                        1};
      const auto world = frame.world(mesh.vertices[v]);
      for (std::size_t r = 0; r < 3; ++r) {
        double at = eye[r];
        for (std::size_t c = 0; c < 4; ++c) at += both[4 * c + r] * index[c];
        EXPECT_NEAR(at, world[r], 1e-6 * (1 + std::abs(world[r])));
      }
    }
  }
}

TEST(ScalarCodec, RefusesEveryBeginningOfAPayload) {
  std::mt19937 random(7);
  for (const TileMesh& mesh : {random_tile(random).mesh(), random_holed_tile(random).mesh()}) {
    const auto bytes = *kCodec.encode(mesh);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(kCodec.decode(std::span(bytes).first(size)).has_value()) << size << " of " << bytes.size();
    }
    auto longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(kCodec.decode(longer).has_value());
  }
}

TEST(ScalarCodec, WhatDecodesAndIsValidEncodes) {
  std::mt19937 random(8);
  int decoded = 0;
  for (int i = 0; i < 3000; ++i) {
    const TileMesh whole = i % 2 == 0 ? random_tile(random).mesh() : random_holed_tile(random).mesh();
    if (whole.triangles.empty()) continue;
    auto bytes = *kCodec.encode(whole);
    for (auto hits = 1 + random() % 3; hits > 0; --hits)
      bytes[random() % std::min<std::size_t>(bytes.size(), 60)] ^= static_cast<std::byte>(1U << random() % 8);
    const auto mesh = kCodec.decode(bytes);
    if (!mesh || !validate(*mesh, 4096) || mesh->triangles.empty()) continue;
    ++decoded;
    ASSERT_TRUE(kCodec.encode(*mesh).has_value()) << i;
  }
  EXPECT_GT(decoded, 100);
}

}  // namespace
}  // namespace tintree::codec
