#include "codec/nested_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "codec/nested_tile.h"
#include "codec/split_hierarchy.h"
#include "tests/codec/random_mesh.h"
#include "tests/codec/round_trip.h"

namespace tintree::codec {
namespace {

const NestedMesh kCodec;

/// Random points of a tile 2^side_bits steps wide, with those that they need, each on a random level or coarser.
class RandomPoints {
 public:
  RandomPoints(unsigned seed, int side_bits, int count, int levels, double gaps, int height_range)
      : random_(seed), gaps_(gaps), height_range_(height_range), points_(side_bits), wanted_(levels) {
    const int side = points_.side();
    for (int level = 0; level < levels; ++level) {
      for (int i = 0; i < count; ++i) {
        // Mostly near one another.
        const int reach = 1 + side / (1 << (random_() % 4));
        want({std::min<std::int64_t>(side, random_() % static_cast<unsigned>(reach)),
              std::min<std::int64_t>(side, random_() % static_cast<unsigned>(reach))},
             level);
      }
    }
    for (std::int32_t i = 0; i < NestedPoints::kBasePoints; ++i) {
      const auto [x, y] = points_.base_place(i);
      add(x, y, 0);
    }
    for (int level = 0; level < levels; ++level) {
      for (const auto& [x, y] : wanted_[static_cast<std::size_t>(level)]) {
        if (points_.find(x, y) < 0) add(x, y, level);
      }
    }
  }

  const NestedPoints& points() const { return points_; }

 private:
  void want(const SplitPoint& p, int level) {
    const std::int64_t side = points_.side();
    if (p.x < 0 || p.y < 0 || p.x > side || p.y > side) return;
    const std::array<std::int32_t, 2> place{static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y)};
    if ((p.x % side == 0 && p.y % side == 0) || !wanted_[static_cast<std::size_t>(level)].insert(place).second) return;
    if (2 * p.x == side && 2 * p.y == side) return;
    for (const SplitPoint& parent : split_parents(p)) want(parent, level);
  }
  void add(std::int32_t x, std::int32_t y, int level) {
    const bool gap = static_cast<double>(random_() % 1000) < 1000 * gaps_;
    const auto z = static_cast<std::int32_t>(random_() % static_cast<unsigned>(height_range_));
    points_.add({x, y, gap ? 0 : z, static_cast<std::uint8_t>(level), gap});
  }

  std::mt19937 random_;
  double gaps_;
  int height_range_;
  NestedPoints points_;
  std::vector<std::set<std::array<std::int32_t, 2>>> wanted_;
};

TileMesh random_nested(unsigned seed, int side_bits, int count, int levels, double gaps = 0, int height_range = 500) {
  TileMesh mesh = finest_mesh(RandomPoints(seed, side_bits, count, levels, gaps, height_range).points());
  mesh.z_offset = static_cast<std::int64_t>(seed) * 1000 - 3000;
  mesh.xy_shift = static_cast<int>(seed % 5) - 1;
  return mesh;
}

void expect_round_trip(const TileMesh& mesh) {
  const auto made = test::expect_round_trip(kCodec, kCodec, mesh);
  ASSERT_TRUE(made);
  EXPECT_EQ(*kCodec.encode(made->back), made->bytes);
}

TEST(NestedMesh, KeepsRandomMeshes) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const int levels = 1 + static_cast<int>(seed % 9);
    expect_round_trip(random_nested(seed, 1 + static_cast<int>(seed % 9), 4, levels, 0.1 * (seed % 3),
                                    seed % 7 == 0 ? kMaxHeightAddress : 300));
    if (HasFailure()) return;
  }
}

TEST(NestedMesh, KeepsATileOfFourTriangles) { expect_round_trip(random_nested(1, 8, 0, 1)); }

TEST(NestedMesh, HasNoEdgeThatEndsInAnother) {
  const TileMesh mesh = random_nested(3, 7, 20, 5);
  ASSERT_TRUE(validate(mesh, 1 << (7 + mesh.xy_shift)));
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  std::int64_t area = 0;
  for (const Triangle& t : mesh.triangles) {
    area += doubled_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(edges.insert({t[k], t[(k + 1) % 3]}).second);
  }
  EXPECT_EQ(area, 2 * 128 * 128);
  for (const auto& [a, b] : edges) {
    if (edges.contains({b, a})) continue;
    const GridVertex& p = mesh.vertices[a];
    const GridVertex& q = mesh.vertices[b];
    EXPECT_TRUE((p.x == q.x && p.x % 128 == 0) || (p.y == q.y && p.y % 128 == 0));
  }
}

TEST(NestedMesh, RefusesOtherMeshes) {
  std::mt19937 random(5);
  TileMesh other = test::random_mesh(random, {.columns = 4, .rows = 4});
  EXPECT_FALSE(kCodec.encode(other).has_value());
  EXPECT_FALSE(kCodec.encode(TileMesh{}).has_value());
  other.nested_levels.assign(other.vertices.size(), 0);
  EXPECT_FALSE(kCodec.encode(other).has_value());
  TileMesh mesh = random_nested(4, 5, 5, 3);
  mesh.triangles.pop_back();
  EXPECT_FALSE(kCodec.encode(mesh).has_value()) << "a triangle is missing";
  mesh = random_nested(4, 5, 5, 3);
  mesh.nested_levels.front() = 12;
  EXPECT_FALSE(kCodec.encode(mesh).has_value()) << "no such level";
}

TEST(NestedMesh, NoticesEveryTruncation) {
  const auto bytes = *kCodec.encode(random_nested(6, 6, 10, 4, 0.1));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(kCodec.decode(cut).has_value()) << size << " of " << bytes.size() << " bytes";
  }
}

TEST(NestedMesh, SurvivesFlippedBytes) {
  std::mt19937 random(16);
  int refused = 0;
  for (unsigned m = 0; m < 8; ++m) {
    const auto bytes = *kCodec.encode(random_nested(m, 6, 8, 5, 0.05 * (m % 3)));
    for (int i = 0; i < 200; ++i) {
      auto damaged = bytes;
      damaged[random() % damaged.size()] ^= static_cast<std::byte>(1 + random() % 255);
      const auto mesh = kCodec.decode(damaged);
      if (!mesh || !validate(*mesh, 64)) {
        ++refused;
      } else if (!mesh->triangles.empty()) {
        EXPECT_TRUE(kCodec.encode(*mesh).has_value()) << "what decodes can be encoded";
      }
    }
  }
  EXPECT_GT(refused, 400);
}

/// The first levels of a payload.
class NestedTileTest : public testing::TestWithParam<double> {
 protected:
  void SetUp() override {
    const RandomPoints made(7, 7, 8, kLevels, GetParam(), 400);
    mesh_ = finest_mesh(made.points());
    bytes_ = *kCodec.encode(mesh_);
    whole_ = *decode_nested(bytes_);
    prefix_ = *nested_prefix_bytes(bytes_);
  }

  static std::vector<Triangle> triangles_of(const std::vector<std::uint32_t>& fans) {
    std::vector<Triangle> out;
    std::size_t begin = 0;
    for (std::size_t i = 0; i < fans.size(); ++i) {
      if (fans[i] == NestedFans::kRestart) {
        begin = i + 1;
      } else if (i >= begin + 2) {
        out.push_back({fans[begin], fans[i - 1], fans[i]});
      }
    }
    return out;
  }

  static constexpr int kLevels = NestedTile::kMostLevels;
  TileMesh mesh_;
  std::vector<std::byte> bytes_;
  NestedTile whole_;
  std::vector<std::size_t> prefix_;
};

TEST_P(NestedTileTest, ReadsALevelFromThePrefixThatHoldsIt) {
  ASSERT_EQ(prefix_.size(), static_cast<std::size_t>(kLevels));
  EXPECT_EQ(prefix_.back(), bytes_.size());
  for (int levels = 1; levels <= kLevels; ++levels) {
    const std::size_t length = prefix_[static_cast<std::size_t>(levels) - 1];
    // A copy of its own lets AddressSanitizer see a read beyond the end.
    const std::vector<std::byte> cut(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(length));
    const auto part = decode_nested(cut, levels);
    ASSERT_TRUE(part.has_value()) << part.error().text();
    const auto last = static_cast<std::size_t>(levels) - 1;
    EXPECT_EQ(part->levels, levels);
    EXPECT_EQ(part->fans[last], whole_.fans[last]);
    ASSERT_EQ(part->vertices.size(), whole_.level_vertices[last]);
    EXPECT_TRUE(std::ranges::equal(part->vertices, std::span(whole_.vertices).first(part->vertices.size())));
    const std::vector<std::byte> less(cut.begin(), cut.end() - 1);
    EXPECT_FALSE(decode_nested(less, levels).has_value());
  }
}

TEST_P(NestedTileTest, FinestLevelIsTheTile) {
  TileMesh drawn;
  drawn.vertices = whole_.vertices;
  drawn.triangles = triangles_of(whole_.fans.back());
  EXPECT_EQ(test::triangle_set(drawn), test::triangle_set(mesh_));
  EXPECT_EQ(whole_.level_triangles.back(), mesh_.triangles.size());
}

TEST_P(NestedTileTest, LevelsAreNested) {
  // Each triangle of a level lies in one of the level before: its middle does, and so do its corners.
  for (std::size_t i = 1; i < static_cast<std::size_t>(kLevels); ++i) {
    const auto coarse = triangles_of(whole_.fans[i - 1]);
    for (const Triangle& t : triangles_of(whole_.fans[i])) {
      int holders = 0;
      for (const Triangle& c : coarse) {
        const bool all = std::ranges::all_of(t, [&](std::uint32_t v) {
          const GridVertex& p = whole_.vertices[v];
          for (std::size_t k = 0; k < 3; ++k) {
            if (doubled_area(whole_.vertices[c[k]], whole_.vertices[c[(k + 1) % 3]], p) < 0) return false;
          }
          return true;
        });
        holders += all ? 1 : 0;
      }
      // With gaps a coarse triangle may be missing where finer ones are.
      if (GetParam() == 0) {
        EXPECT_EQ(holders, 1);
      } else {
        EXPECT_LE(holders, 1);
      }
    }
  }
}

TEST_P(NestedTileTest, MorphsReachTheCoarserMeshes) {
  for (int i = 0; i + 1 < kLevels; ++i) {
    const double unit = std::ldexp(1.0, whole_.morph_exponent[static_cast<std::size_t>(i)]);
    const auto coarse = triangles_of(whole_.fans[static_cast<std::size_t>(i)]);
    for (std::size_t v = 0; v < whole_.vertices.size(); ++v) {
      const GridVertex& p = whole_.vertices[v];
      for (const Triangle& t : coarse) {
        const std::array<GridVertex, 3> c{whole_.vertices[t[0]], whole_.vertices[t[1]], whole_.vertices[t[2]]};
        const std::array<std::int64_t, 3> w{doubled_area(p, c[1], c[2]), doubled_area(p, c[2], c[0]),
                                            doubled_area(p, c[0], c[1])};
        if (std::ranges::min(w) < 0) continue;
        const double z = static_cast<double>(w[0] * c[0].z + w[1] * c[1].z + w[2] * c[2].z) /
                         static_cast<double>(w[0] + w[1] + w[2]);
        // Beside a gap a finer point has no coarser triangle that it splits.
        if (GetParam() == 0 || v < whole_.level_vertices[static_cast<std::size_t>(i)]) {
          EXPECT_NEAR(whole_.height(v, i), z, unit / 2 + 1e-3) << "vertex " << v << " level " << i;
        }
        break;
      }
    }
  }
}

TEST_P(NestedTileTest, FansNameOnlyTheirLevelsVertices) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(kLevels); ++i) {
    for (const std::uint32_t v : whole_.fans[i]) EXPECT_TRUE(v == NestedFans::kRestart || v < whole_.level_vertices[i]);
    EXPECT_EQ(triangles_of(whole_.fans[i]).size(), whole_.level_triangles[i]);
  }
}

INSTANTIATE_TEST_SUITE_P(Gaps, NestedTileTest, testing::Values(0.0, 0.03));

TEST(NestedTile, TakesFewIndicesForAFullGrid) {
  NestedPoints points(6);
  for (std::int32_t i = 0; i < NestedPoints::kBasePoints; ++i) {
    const auto [x, y] = points.base_place(i);
    points.add({x, y, 0, 0, false});
  }
  for (std::int32_t y = 0; y <= 64; ++y) {
    for (std::int32_t x = 0; x <= 64; ++x) {
      if (points.find(x, y) < 0) points.add({x, y, 0, 0, false});
    }
  }
  const auto tile = decode_nested(*kCodec.encode(finest_mesh(points)));
  ASSERT_TRUE(tile.has_value());
  EXPECT_EQ(tile->level_triangles.back(), 2U * 64 * 64);
  // A fan round each square's centre: eight triangles in eleven indices.
  EXPECT_EQ(tile->fans.back().size(), 32U * 32 * 11);
}

}  // namespace
}  // namespace tintree::codec
