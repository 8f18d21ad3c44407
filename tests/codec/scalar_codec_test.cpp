#include "codec/scalar_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
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
#include "tests/codec/round_trip.h"

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

std::vector<GridBlock> leaves(const ScalarShape& shape) {
  std::vector<GridBlock> out;
  shape.blocks.for_each([&](const GridBlock& block) { out.push_back(block); });
  return out;
}

/// Where blocks that are not empty share an edge.
bool adjoin(const GridBlock& a, const GridBlock& b) {
  if (a.empty || b.empty) return false;
  const std::int32_t reach_a = kBlockCells * a.stride;
  const std::int32_t reach_b = kBlockCells * b.stride;
  const std::int32_t dx = std::min(a.x + reach_a, b.x + reach_b) - std::max(a.x, b.x);
  const std::int32_t dy = std::min(a.y + reach_a, b.y + reach_b) - std::max(a.y, b.y);
  return (dx == 0 && dy > 0) || (dx > 0 && dy == 0);
}

/// Block over every place next to a side.
GridBlock next_to(const ScalarShape& shape, int side, std::int32_t at) {
  switch (side) {
    case ScalarShape::kNorth:
      return shape.blocks.at(at, 0);
    case ScalarShape::kEast:
      return shape.blocks.at(shape.width() - 1, at);
    case ScalarShape::kSouth:
      return shape.blocks.at(at, shape.height() - 1);
    default:
      return shape.blocks.at(0, at);
  }
}

/// Splits one block that the shape may not have as it is; false when there is none.
bool split_one(ScalarShape& shape) {
  const std::vector<GridBlock> all = leaves(shape);
  for (const GridBlock& a : all) {
    for (const GridBlock& b : all) {
      if (!adjoin(a, b) || a.stride <= 2 * b.stride) continue;
      shape.blocks.split(a.node);
      return true;
    }
  }
  for (int side = 0; side < 4; ++side) {
    const auto& places = shape.sides[static_cast<std::size_t>(side)];
    for (std::size_t k = 0; k + 1 < places.size(); ++k) {
      for (std::int32_t at = places[k]; at + 1 < places[k + 1]; ++at) {
        const GridBlock a = next_to(shape, side, at);
        const GridBlock b = next_to(shape, side, at + 1);
        if (a.stride == b.stride) continue;
        shape.blocks.split(a.stride > b.stride ? a.node : b.node);
        return true;
      }
    }
  }
  return false;
}

void put_heights(std::mt19937& random, ScalarTile& tile) {
  const std::int32_t step = 1 + static_cast<std::int32_t>(random() % 9);
  const auto levels = static_cast<std::int32_t>(1 + random() % (random() % 2 == 0 ? 4 : 3000));
  const auto grid = make_scalar_grid(tile.shape);
  ASSERT_TRUE(grid.has_value());
  for (std::size_t i = 0; i < grid->places.size(); ++i) {
    const auto level = static_cast<std::int32_t>(random()) & 0xffff;
    tile.z.push_back(i < grid->border_count ? level : level % levels * step);
  }
}

/// A tile of any size, its sides and blocks halved at random.
ScalarTile random_tile(std::mt19937& random) {
  ScalarTile tile;
  const auto width = 2 + static_cast<std::int32_t>(random() % 60);
  const auto height = 2 + static_cast<std::int32_t>(random() % 60);
  std::int32_t stride = 1;
  while (random() % 4 != 0 && 2 * stride < std::min(width, height)) stride *= 2;
  ScalarShape& shape = tile.shape;
  shape.blocks = BlockTree(width, height, stride);
  for (int side = 0; side < 4; ++side) {
    auto& places = shape.sides[static_cast<std::size_t>(side)];
    places.push_back(0);
    halve(random, 0, 64, shape.length(side), 1 + static_cast<unsigned>(random() % 3), places);
  }
  for (auto splits = random() % 8; splits > 0; --splits) {
    const auto below = [&](std::int32_t end) {
      return static_cast<std::int32_t>(random() % static_cast<unsigned>(end));
    };
    const GridBlock block = shape.blocks.at(below(width), below(height));
    if (block.stride > 1) shape.blocks.split(block.node);
  }
  while (split_one(shape)) {
  }
  tile.xy_shift = static_cast<int>(random() % 33) - 3;
  tile.z_offset = static_cast<std::int64_t>(random()) - (std::int64_t{1} << 31);
  put_heights(random, tile);
  return tile;
}

/// One that lacks vertices at random, and blocks away from longer edges of sides.
ScalarTile random_holed_tile(std::mt19937& random) {
  ScalarTile tile = random_tile(random);
  for (const GridBlock& block : leaves(tile.shape)) {
    const bool inside = block.x > 0 && block.y > 0 && block.x + kBlockCells * block.stride < tile.shape.width() &&
                        block.y + kBlockCells * block.stride < tile.shape.height();
    if (inside && random() % 3 == 0) tile.shape.blocks.set_empty(block.node);
  }
  tile.z.clear();
  put_heights(random, tile);
  const auto chance = random() % 90;
  for (std::size_t i = 0; i < tile.z.size(); ++i) tile.missing.push_back(random() % 100 < chance);
  return tile;
}

TileMesh mesh_of(const ScalarTile& tile) { return tile.mesh(*make_scalar_grid(tile.shape)); }

void expect_round_trip(const TileMesh& mesh) {
  const auto made = test::expect_round_trip(kCodec, kCodec, mesh);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->back.vertices.size(), mesh.vertices.size());
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
  int mixed = 0;
  for (int i = 0; i < 400 && !testing::Test::HasFailure(); ++i) {
    const ScalarTile tile = random_tile(random);
    const TileMesh mesh = mesh_of(tile);
    const ScalarShape& s = tile.shape;
    const std::vector<GridBlock> blocks = leaves(s);
    mixed += blocks.front().stride != blocks.back().stride ? 1 : 0;
    SCOPED_TRACE(testing::Message() << "tile " << i << ", " << s.width() << " x " << s.height());
    EXPECT_EQ(doubled_cover(mesh), 2 * std::int64_t{s.width()} * s.height());
    // A disk without a vertex inside an edge: Euler's formula gives the triangles.
    EXPECT_EQ(mesh.triangles.size(), 2 * mesh.vertices.size() - 2 - s.border_count());
    // The sides' vertices are those asked for, and no other.
    EXPECT_EQ(s.border_count(), static_cast<std::size_t>(std::ranges::count_if(mesh.vertices, [&](const GridVertex& v) {
                return v.x == 0 || v.y == 0 || v.x == s.width() || v.y == s.height();
              })));
  }
  EXPECT_GT(mixed, 50) << "the test has few tiles of several strides";
}

TEST(ScalarGrid, LeavesOutEmptyBlocksAlone) {
  std::mt19937 random(9);
  for (int i = 0; i < 200 && !testing::Test::HasFailure(); ++i) {
    ScalarTile tile = random_holed_tile(random);
    tile.missing.clear();
    const TileMesh mesh = mesh_of(tile);
    std::int64_t empty = 0;
    for (const GridBlock& block : leaves(tile.shape)) {
      if (block.empty) empty += std::int64_t{kBlockCells} * kBlockCells * block.stride * block.stride;
    }
    EXPECT_EQ(doubled_cover(mesh), 2 * (std::int64_t{tile.shape.width()} * tile.shape.height() - empty));
  }
}

TEST(ScalarGrid, OfEverySampleIsTheSurfacesOwnTriangulation) {
  ScalarShape shape{BlockTree(7, 5, 1), {}};
  for (int side = 0; side < 4; ++side) {
    for (std::int32_t at = 0; at <= shape.length(side); ++at) shape.sides[static_cast<std::size_t>(side)].push_back(at);
  }
  const auto grid = make_scalar_grid(shape);
  ASSERT_EQ(grid->places.size(), 48U);
  ASSERT_EQ(grid->triangles.size(), 70U);
  for (const Triangle& t : grid->triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t dx = grid->places[t[(k + 1) % 3]].x - grid->places[t[k]].x;
      const std::int32_t dy = grid->places[t[(k + 1) % 3]].y - grid->places[t[k]].y;
      EXPECT_TRUE(std::abs(dx) <= 1 && std::abs(dy) <= 1 && dx * dy >= 0) << dx << ", " << dy;
    }
  }
}

TEST(ScalarGrid, RefusesWhatIsNoPartitionAndWhatIsTooLarge) {
  ScalarShape shape{BlockTree(64, 64, 4), {}};
  for (auto& places : shape.sides) places = {0, 16, 32, 48, 64};
  EXPECT_TRUE(make_scalar_grid(shape).has_value());
  // Blocks of stride 1 next to some of stride 4.
  ScalarShape steep = shape;
  steep.blocks.split(steep.blocks.at(16, 16).node);
  steep.blocks.split(steep.blocks.at(16, 16).node);
  EXPECT_FALSE(make_scalar_grid(steep).has_value());
  // Strides of 2 and 4 along one edge of a side.
  ScalarShape uneven = shape;
  uneven.sides[ScalarShape::kNorth] = {0, 32, 64};
  uneven.blocks.split(uneven.blocks.at(16, 0).node);
  EXPECT_FALSE(make_scalar_grid(uneven).has_value());
  ScalarShape large{BlockTree(8200, 8200, 2), {}};
  for (auto& places : large.sides) places = {0, 8200};
  EXPECT_FALSE(make_scalar_grid(large).has_value());
}

TEST(ScalarCodec, KeepsRandomTiles) {
  std::mt19937 random(2);
  for (int i = 0; i < 400 && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE("tile " + std::to_string(i));
    expect_round_trip(mesh_of(random_tile(random)));
  }
}

TEST(ScalarCodec, KeepsTilesWithHoles) {
  std::mt19937 random(3);
  int pinched = 0;
  for (int i = 0; i < 300 && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE("tile " + std::to_string(i));
    const TileMesh mesh = mesh_of(random_holed_tile(random));
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
    tile.shape.blocks = wide ? BlockTree(9, 1, 1) : BlockTree(1, 9, 1);
    for (int side = 0; side < 4; ++side) {
      for (std::int32_t at = 0; at <= tile.shape.length(side); ++at)
        tile.shape.sides[static_cast<std::size_t>(side)].push_back(at);
    }
    for (std::int32_t i = 0; i < 20; ++i) tile.z.push_back(i * i);
    EXPECT_EQ(doubled_cover(mesh_of(tile)), 18);
    expect_round_trip(mesh_of(tile));
  }
}

TEST(ScalarCodec, RefusesWhatIsNoGrid) {
  TileMesh lone;
  lone.vertices = {{0, 0, 1}, {2, 3, 2}, {5, 1, 3}};
  lone.triangles = {{0, 1, 2}};
  EXPECT_FALSE(kCodec.encode(lone).has_value());
  std::mt19937 random(4);
  TileMesh flipped = mesh_of(random_tile(random));
  flipped.triangles.pop_back();
  EXPECT_FALSE(kCodec.encode(flipped).has_value());
}

/// Moved vertices, values beyond the format's, triangles turned: refused, or bytes that give the mesh back.
TEST(ScalarCodec, EncodesNothingThatItWouldRefuseToDecode) {
  std::mt19937 random(6);
  int refused = 0;
  for (int i = 0; i < 600 && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE("mesh " + std::to_string(i));
    TileMesh mesh = mesh_of(i % 2 == 0 ? random_tile(random) : random_holed_tile(random));
    if (mesh.triangles.empty()) continue;
    GridVertex& v = mesh.vertices[random() % mesh.vertices.size()];
    const auto near = static_cast<std::int32_t>(random() % 5) - 2;
    const auto far = std::array{-1, kMaxHeightAddress, kMaxHeightAddress + 1, INT32_MIN, INT32_MAX}[random() % 5];
    switch (random() % 6) {
      case 0:
        v.z = far;
        break;
      case 1:
        v.x += near;
        break;
      case 2:
        v.y += near;
        break;
      case 3:
        v.x = v.y = far;
        break;
      case 4:
        mesh.xy_shift += static_cast<int>(random() % 600) - 300;
        break;
      default:
        mesh.z_offset = (std::int64_t{1} << (40 + random() % 23)) * (random() % 2 == 0 ? 1 : -1);
    }
    if (kCodec.encode(mesh)) {
      expect_round_trip(mesh);
    } else {
      ++refused;
    }
  }
  EXPECT_GT(refused, 200) << "the test has few meshes that do not fit";
}

TEST(ScalarCodec, RefusesATileWiderThanTheFormats) {
  for (const int shift : {28, 29}) {
    const std::int32_t across = 1 << shift;
    ScalarTile tile;
    tile.shape.blocks = BlockTree(across, across, across / kBlockCells);
    for (auto& places : tile.shape.sides) places = {0, across};
    tile.z.assign(make_scalar_grid(tile.shape)->places.size(), 7);
    if (shift == 28) {
      expect_round_trip(mesh_of(tile));
    } else {
      EXPECT_FALSE(kCodec.encode(mesh_of(tile)).has_value());
    }
  }
}

TEST(ScalarCodec, DecodesToTheQuantizerOfTheHeightsInside) {
  std::mt19937 random(7);
  int tables = 0;
  int uniform = 0;
  for (int i = 0; i < 200; ++i) {
    ScalarTile tile = random_tile(random);
    if (i % 2 == 0) {
      for (std::size_t k = make_scalar_grid(tile.shape)->border_count; k < tile.z.size(); ++k)
        tile.z[k] = std::array{5, 900, 30001}[random() % 3];
    }
    const auto back = kCodec.decode(*kCodec.encode(mesh_of(tile)));
    ASSERT_TRUE(back.has_value());
    std::vector<std::int32_t> heights;
    for (const GridVertex& v : back->vertices) {
      const ScalarShape& s = *back->scalar_shape;
      if (v.x != 0 && v.y != 0 && v.x != s.width() && v.y != s.height()) heights.push_back(v.z);
    }
    ASSERT_EQ(back->height_quantizer.has_value(), !heights.empty()) << i;
    if (heights.empty()) continue;
    const auto& [low, step, table] = *back->height_quantizer;
    (table.empty() ? uniform : tables) += 1;
    EXPECT_TRUE(std::ranges::is_sorted(table));
    for (const std::int32_t z : heights) {
      ASSERT_TRUE(table.empty() ? z >= low && (z - low) % step == 0 : std::ranges::binary_search(table, z)) << i;
    }
  }
  EXPECT_GT(tables, 20);
  EXPECT_GT(uniform, 20);
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
    for (std::int32_t& z : tile.z) z = offset + step * static_cast<std::int32_t>(random() % 64);
    const TileMesh mesh = mesh_of(tile);
    const GridFrame frame(layout, {1, 1, 1}, mesh);
    const auto m = frame.matrix(eye);
    for (const GridVertex& v : mesh.vertices) {
      const GridBlock block =
          tile.shape.blocks.at(std::min(v.x, tile.shape.width() - 1), std::min(v.y, tile.shape.height() - 1));
      if ((v.x - block.x) % block.stride != 0 || (v.y - block.y) % block.stride != 0) continue;
      const auto q = inverse_quantization(block, step, offset);
      const std::array<std::int32_t, 4> index{(v.x - block.x) / block.stride, (v.y - block.y) / block.stride,
                                              (v.z - offset) / step, 1};
      const auto world = frame.world(v);
      for (std::size_t r = 0; r < 3; ++r) {
        double at = eye[r];
        for (std::size_t c = 0; c < 4; ++c) {
          for (std::size_t k = 0; k < 4; ++k) at += m[4 * k + r] * q[4 * c + k] * index[c];
        }
        EXPECT_NEAR(at, world[r], 1e-6 * (1 + std::abs(world[r])));
      }
    }
  }
}

TEST(ScalarCodec, RefusesEveryBeginningOfAPayload) {
  std::mt19937 random(7);
  for (const TileMesh& mesh : {mesh_of(random_tile(random)), mesh_of(random_holed_tile(random))}) {
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
    const TileMesh whole = i % 2 == 0 ? mesh_of(random_tile(random)) : mesh_of(random_holed_tile(random));
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
