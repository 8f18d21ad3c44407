#include "codec/strip_mesh.h"

#include <random>

#include <gtest/gtest.h>

#include "codec/coded_strip_mesh.h"
#include "codec/strip_payload.h"
#include "tests/codec/random_mesh.h"
#include "tests/codec/random_quadtree.h"

namespace tintree::codec {
namespace {

using test::QuadtreeSpec;
using test::random_quadtree;
using test::triangle_set;

const StripMesh kCodec;
const CodedStripMesh kCoded;

void expect_round_trip(const MeshCodec& codec, const TileMesh& mesh) {
  const auto bytes = codec.encode(mesh);
  ASSERT_TRUE(bytes.has_value()) << bytes.error().text();
  const auto back = codec.decode(*bytes);
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->xy_shift, mesh.xy_shift);
  EXPECT_EQ(triangle_set(*back), triangle_set(mesh));
  EXPECT_EQ(back->vertices.size(), mesh.vertices.size());
  EXPECT_EQ(*codec.encode(*back), *bytes);
}

/// In either payload version.
void expect_round_trip(const TileMesh& mesh) {
  expect_round_trip(kCodec, mesh);
  expect_round_trip(kCoded, mesh);
  const auto packed = *kCodec.encode(mesh);
  EXPECT_EQ(*packed_strip(*kCoded.encode(mesh)), packed);
  EXPECT_EQ(*packed_strip(packed), packed);
}

TEST(StripMesh, KeepsRandomQuadtrees) {
  std::mt19937 random(21);
  for (int i = 0; i < 150; ++i) {
    SCOPED_TRACE("mesh " + std::to_string(i));
    QuadtreeSpec spec{.levels = 1 + i % 6, .splits = i % 40};
    spec.height_unit = 1 << (i % 3);
    spec.height_range = i % 7 == 0 ? 0 : i % 5 == 0 ? kMaxHeightAddress : 3000;
    TileMesh mesh = random_quadtree(random, spec);
    mesh.xy_shift = i % 9 - 1;
    mesh.z_offset = static_cast<std::int64_t>(random()) - (std::int64_t{1} << 31);
    expect_round_trip(mesh);
    if (HasFailure()) return;
  }
}

TEST(StripMesh, KeepsHoles) {
  std::mt19937 random(22);
  for (int i = 0; i < 150; ++i) {
    SCOPED_TRACE("mesh " + std::to_string(i));
    const TileMesh mesh =
        random_quadtree(random, {.levels = 1 + i % 5, .splits = 5 + i % 30, .missing = 0.02 * (1 + i % 20)});
    if (mesh.triangles.empty()) continue;
    expect_round_trip(mesh);
    if (HasFailure()) return;
  }
}

TEST(StripMesh, KeepsLargeTiles) {
  // Beyond 2^10 steps headers take 64 bits.
  std::mt19937 random(23);
  for (const int levels : {10, 11, 16}) {
    const TileMesh mesh = random_quadtree(random, {.levels = levels, .splits = 30});
    expect_round_trip(mesh);
    const auto bytes = *kCodec.encode(mesh);
    const StripPayload payload = *open_strip(bytes);
    EXPECT_EQ(payload.headers.size(), (levels > 10 ? 8U : 4U) * ((payload.triangles + 15) / 16));
  }
}

TEST(StripMesh, TakesTheBitsOfThePaper) {
  std::mt19937 random(24);
  const TileMesh mesh = random_quadtree(random, {.levels = 7, .splits = 300, .height_range = 127});
  const auto bytes = *kCodec.encode(mesh);
  const auto triangles = static_cast<double>(mesh.triangles.size());
  // 2 for the type, 7 for the height, 32 / 16 for the header; the head and what is rounded up are a few bytes.
  EXPECT_NEAR(8 * static_cast<double>(bytes.size()), 11 * triangles, 8 * 24);
}

TEST(StripMesh, RefusesWhatIsNoRestrictedQuadtree) {
  std::mt19937 random(25);
  EXPECT_FALSE(kCodec.encode(TileMesh{}).has_value());
  EXPECT_FALSE(kCodec.encode(test::random_mesh(random, {.columns = 7, .rows = 5})).has_value());
  const TileMesh good = random_quadtree(random, {.levels = 4, .splits = 10});
  TileMesh moved = good;
  moved.vertices[7].x ^= 1;
  EXPECT_FALSE(kCodec.encode(moved).has_value());
  TileMesh twice = good;
  twice.triangles.push_back(good.triangles.front());
  EXPECT_FALSE(kCodec.encode(twice).has_value());
  TileMesh flipped = good;
  std::swap(flipped.triangles[3][0], flipped.triangles[3][1]);
  EXPECT_FALSE(kCodec.encode(flipped).has_value());
  TileMesh torn = good;
  torn.vertices.push_back(torn.vertices[good.triangles[2][0]]);
  ++torn.vertices.back().z;
  torn.triangles[2][0] = static_cast<std::uint32_t>(torn.vertices.size() - 1);
  EXPECT_FALSE(kCodec.encode(torn).has_value());
}

TEST(StripMesh, NoticesEveryTruncationAndExcess) {
  std::mt19937 random(26);
  for (const MeshCodec* codec : {static_cast<const MeshCodec*>(&kCodec), static_cast<const MeshCodec*>(&kCoded)}) {
    for (const double missing : {0.0, 0.1}) {
      auto bytes = *codec->encode(random_quadtree(random, {.levels = 4, .splits = 20, .missing = missing}));
      for (std::size_t size = 0; size < bytes.size(); ++size) {
        const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_FALSE(codec->decode(cut).has_value()) << size;
      }
      bytes.push_back(std::byte{0});
      EXPECT_FALSE(codec->decode(bytes).has_value());
    }
  }
}

TEST(StripMesh, SurvivesFlippedBytes) {
  std::mt19937 random(27);
  for (int m = 0; m < 12; ++m) {
    const MeshCodec& codec = m % 4 < 2 ? static_cast<const MeshCodec&>(kCodec) : kCoded;
    const auto bytes =
        *codec.encode(random_quadtree(random, {.levels = 3 + m % 3, .splits = 20, .missing = m % 2 * 0.1}));
    for (int i = 0; i < 300; ++i) {
      auto damaged = bytes;
      for (int f = 0; f <= i % 3; ++f) damaged[random() % damaged.size()] ^= static_cast<std::byte>(1 + random() % 255);
      if (const auto mesh = codec.decode(damaged)) (void)validate(*mesh, 256);
    }
  }
}

}  // namespace
}  // namespace tintree::codec
