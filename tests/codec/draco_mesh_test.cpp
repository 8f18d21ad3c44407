#include "codec/draco_mesh.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/codec/random_mesh.h"

namespace tintree::codec {
namespace {

using test::MeshSpec;
using test::random_mesh;
using test::triangle_set;

const DracoMesh kCodec;

void expect_round_trip(const TileMesh& mesh) {
  const auto bytes = kCodec.encode(mesh);
  ASSERT_TRUE(bytes.has_value()) << bytes.error().text();
  const auto again = kCodec.encode(mesh);
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(*bytes, *again) << "encoding is not deterministic";
  const auto back = kCodec.decode(*bytes);
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->xy_shift, mesh.xy_shift);
  EXPECT_EQ(back->z_offset, mesh.z_offset);
  EXPECT_EQ(triangle_set(*back), triangle_set(mesh));
}

TEST(DracoMesh, KeepsASingleTriangle) {
  TileMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 256, 65535}, {256, 256, 7}};
  mesh.triangles = {{0, 1, 2}};
  expect_round_trip(mesh);
}

TEST(DracoMesh, KeepsTwoTrianglesThatDoNotTouch) {
  TileMesh mesh;
  mesh.vertices = {{0, 0, 1}, {0, 4, 2}, {4, 4, 3}, {100, 100, 4}, {100, 104, 5}, {104, 104, 6}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  expect_round_trip(mesh);
}

TEST(DracoMesh, KeepsTwoTrianglesThatShareOneVertex) {
  TileMesh mesh;
  mesh.vertices = {{4, 4, 1}, {0, 0, 2}, {0, 4, 3}, {8, 4, 4}, {8, 8, 5}};
  mesh.triangles = {{0, 1, 2}, {0, 4, 3}};
  expect_round_trip(mesh);
}

TEST(DracoMesh, KeepsAClosedRingAroundAHole) {
  TileMesh mesh;
  for (std::int32_t y = 0; y < 4; ++y) {
    for (std::int32_t x = 0; x < 4; ++x) mesh.vertices.push_back({x, y, x * y});
  }
  for (std::uint32_t y = 0; y < 3; ++y) {
    for (std::uint32_t x = 0; x < 3; ++x) {
      if (x == 1 && y == 1) continue;
      const std::uint32_t v = 4 * y + x;
      mesh.triangles.push_back({v, v + 4, v + 5});
      mesh.triangles.push_back({v, v + 5, v + 1});
    }
  }
  expect_round_trip(mesh);
}

TEST(DracoMesh, KeepsRandomMeshes) {
  std::mt19937 random(11);
  for (int i = 0; i < 400; ++i) {
    MeshSpec spec;
    spec.columns = 1 + static_cast<int>(random() % 24);
    spec.rows = 1 + static_cast<int>(random() % 24);
    spec.drop = i % 4 == 0 ? 0 : 0.2 * (i % 4);
    spec.split = i % 3 == 0 ? 0.1 : 0;
    spec.height_range = i % 5 == 0 ? 65535 : 40;
    spec.z_offset = static_cast<std::int64_t>(random()) - (std::int64_t{1} << 31);
    spec.xy_shift = static_cast<int>(random() % 33) - 3;
    SCOPED_TRACE("mesh " + std::to_string(i));
    expect_round_trip(random_mesh(random, spec));
    if (HasFailure()) return;
  }
}

TEST(DracoMesh, KeepsAMeshAboveTheSizeWhereOneCoderIsTried) {
  std::mt19937 random(12);
  expect_round_trip(random_mesh(random, {.columns = 100, .rows = 60, .drop = 0.02, .height_range = 2000}));
}

TEST(DracoMesh, KeepsEveryHeightOrigin) {
  std::mt19937 random(13);
  TileMesh mesh = random_mesh(random, {.columns = 3, .rows = 3});
  for (const std::int64_t origin : {std::int64_t{0}, std::int64_t{-1}, std::int64_t{63}, std::int64_t{64},
                                    std::int64_t{-64}, std::int64_t{-65}, kMaxHeightOffset, -kMaxHeightOffset}) {
    mesh.z_offset = origin;
    expect_round_trip(mesh);
  }
}

TEST(DracoMesh, RefusesAnEmptyMesh) {
  const auto bytes = kCodec.encode(TileMesh{});
  ASSERT_FALSE(bytes.has_value());
  EXPECT_EQ(bytes.error().code, ErrorCode::kBadData);
}

TEST(DracoMesh, RefusesAnUnknownVersion) {
  std::mt19937 random(14);
  auto bytes = *kCodec.encode(random_mesh(random, {}));
  bytes[0] = std::byte{1};
  const auto mesh = kCodec.decode(bytes);
  ASSERT_FALSE(mesh.has_value());
  EXPECT_EQ(mesh.error().code, ErrorCode::kBadData);
}

TEST(DracoMesh, RefusesAHeightOriginWithoutEnd) {
  const std::vector<std::byte> bytes(40, std::byte{0x81});
  std::vector<std::byte> payload{std::byte{1}, std::byte{0}};
  payload.insert(payload.end(), bytes.begin(), bytes.end());
  EXPECT_FALSE(kCodec.decode(payload).has_value());
}

TEST(DracoMesh, NoticesEveryTruncation) {
  std::mt19937 random(15);
  for (const MeshSpec& spec :
       {MeshSpec{.columns = 1, .rows = 1}, MeshSpec{.columns = 12, .rows = 9, .drop = 0.2, .z_offset = -100000},
        MeshSpec{.columns = 20, .rows = 20}}) {
    const auto bytes = *kCodec.encode(random_mesh(random, spec));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      // A copy of its own lets AddressSanitizer see a read beyond the end.
      const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_FALSE(kCodec.decode(cut).has_value()) << size << " of " << bytes.size() << " bytes";
    }
  }
}

TEST(DracoMesh, SurvivesFlippedBytes) {
  std::mt19937 random(16);
  int refused = 0;
  int tries = 0;
  for (int m = 0; m < 12; ++m) {
    const auto bytes = *kCodec.encode(random_mesh(random, {.columns = 2 + m, .rows = 10, .drop = 0.1 * (m % 3)}));
    for (int i = 0; i < 400; ++i, ++tries) {
      auto damaged = bytes;
      const int flips = 1 + static_cast<int>(random() % 3);
      for (int f = 0; f < flips; ++f) damaged[random() % damaged.size()] ^= static_cast<std::byte>(1 + random() % 255);
      const auto mesh = kCodec.decode(damaged);
      // What gets through is for the checksum to catch; it still has to be safe to check.
      if (!mesh || !validate(*mesh, 16)) ++refused;
    }
  }
  EXPECT_GT(refused, tries / 3);
}

TEST(DracoMesh, SurvivesNoise) {
  std::mt19937 random(17);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> noise(random() % 300);
    for (auto& b : noise) b = static_cast<std::byte>(random());
    if (!noise.empty()) noise[0] = std::byte{1};
    if (const auto mesh = kCodec.decode(noise)) (void)validate(*mesh, 1 << 20);
  }
}

}  // namespace
}  // namespace tintree::codec
