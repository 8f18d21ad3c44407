#include "codec/coded_tin_mesh.h"

#include <random>

#include <gtest/gtest.h>

#include "codec/draco_mesh.h"
#include "codec/split_fans.h"
#include "codec/tin_guess.h"
#include "tests/codec/random_mesh.h"
#include "tests/codec/round_trip.h"

namespace tintree::codec {
namespace {

using test::MeshSpec;
using test::random_mesh;
using test::triangle_set;

const CodedTinMesh kCoded;

/// As the other version has it, to the last triangle and vertex, and decoded through the method's codec.
void expect_round_trip(const TileMesh& mesh, std::byte version = kTinCoded) {
  const auto made = test::expect_round_trip(kCoded, *find_codec("tin"), mesh);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->bytes.front(), version);
  EXPECT_EQ(made->back.vertices.size(), mesh.vertices.size());
}

TileMesh manifold(TileMesh mesh) {
  split_fans(mesh);
  return mesh;
}

/// Points strewn over a square and some corners of its outline, triangulated by inserting one after the other into the
/// triangle that holds it: vertices of three edges and slivers included.
TileMesh strewn_mesh(std::mt19937& random, std::int32_t side, int points) {
  TileMesh mesh;
  mesh.vertices = {{0, 0, 1}, {0, side, 2}, {side, side, 3}, {side, 0, 4}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto any = [&](std::int32_t most) {
    return static_cast<std::int32_t>(random() % (static_cast<std::uint32_t>(most) + 1));
  };
  for (int i = 0; i < points; ++i) {
    const GridVertex p{any(side), any(side), any(3000)};
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto [a, b, c] = mesh.triangles[t];
      const auto inside = [&](std::uint32_t from, std::uint32_t to) {
        return doubled_area(mesh.vertices[from], mesh.vertices[to], p) > 0;
      };
      if (!inside(a, b) || !inside(b, c) || !inside(c, a)) continue;
      const auto v = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(p);
      mesh.triangles[t] = {a, b, v};
      mesh.triangles.push_back({b, c, v});
      mesh.triangles.push_back({c, a, v});
      break;
    }
  }
  return mesh;
}

TEST(CodedTinMesh, KeepsASingleTriangle) {
  TileMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 256, 65535}, {256, 256, 7}};
  mesh.triangles = {{0, 1, 2}};
  expect_round_trip(mesh);
}

TEST(CodedTinMesh, KeepsThePlainestTile) {
  std::mt19937 random(30);
  for (const std::int32_t side : {1, 2, 255, 256, kMostTinPlace}) expect_round_trip(strewn_mesh(random, side, 0));
}

TEST(CodedTinMesh, KeepsStrewnMeshes) {
  std::mt19937 random(31);
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE("mesh " + std::to_string(i));
    expect_round_trip(strewn_mesh(random, 20 + 60 * i * i, 10 * i));
    if (HasFailure()) return;
  }
}

TEST(CodedTinMesh, KeepsGridsHolesAndIslands) {
  std::mt19937 random(32);
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE("mesh " + std::to_string(i));
    MeshSpec spec;
    spec.columns = 1 + static_cast<int>(random() % 24);
    spec.rows = 1 + static_cast<int>(random() % 24);
    spec.drop = 0.01 * static_cast<double>(i % 10 * (i % 10));
    spec.height_range = i % 5 == 0 ? kMaxHeightAddress : 40;
    spec.z_offset = static_cast<std::int64_t>(random()) - (std::int64_t{1} << 31);
    spec.xy_shift = static_cast<int>(random() % 33) - 3;
    expect_round_trip(manifold(random_mesh(random, spec)));
    if (HasFailure()) return;
  }
}

TEST(CodedTinMesh, GivesOtherMeshesToDraco) {
  TileMesh pinched;
  pinched.vertices = {{4, 4, 1}, {0, 0, 2}, {0, 4, 3}, {8, 4, 4}, {8, 8, 5}};
  pinched.triangles = {{0, 1, 2}, {0, 4, 3}};
  EXPECT_EQ(*kCoded.encode(pinched), *DracoMesh().encode(pinched));
  expect_round_trip(manifold(pinched));
  TileMesh wide;
  wide.vertices = {{0, 0, 0}, {0, kMostTinPlace + 1, 1}, {1, 1, 7}};
  wide.triangles = {{0, 1, 2}};
  expect_round_trip(wide, DracoMesh().encode(wide)->front());
  EXPECT_FALSE(kCoded.encode(TileMesh{}).has_value());
}

TEST(CodedTinMesh, TakesFewerBytesThanDraco) {
  std::mt19937 random(33);
  const TileMesh mesh = strewn_mesh(random, 256, 300);
  EXPECT_LT(kCoded.encode(mesh)->size(), DracoMesh().encode(mesh)->size());
}

TEST(CodedTinMesh, NoticesEveryTruncation) {
  std::mt19937 random(34);
  for (const TileMesh& mesh : {strewn_mesh(random, 64, 0), strewn_mesh(random, 64, 40),
                               manifold(random_mesh(random, {.columns = 12, .rows = 9, .drop = 0.2}))}) {
    const auto bytes = *kCoded.encode(mesh);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      // A copy of its own lets AddressSanitizer see a read beyond the end.
      const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_FALSE(kCoded.decode(cut).has_value()) << size << " of " << bytes.size() << " bytes";
    }
  }
}

TEST(CodedTinMesh, SurvivesFlippedBytes) {
  std::mt19937 random(35);
  int refused = 0;
  int tries = 0;
  for (int m = 0; m < 12; ++m) {
    const bool strewn = m % 2 == 0;
    const TileMesh mesh = strewn ? strewn_mesh(random, 256, 40 * m)
                                 : manifold(random_mesh(random, {.columns = 2 + m, .rows = 10, .drop = 0.04 * m}));
    const auto bytes = *kCoded.encode(mesh);
    for (int i = 0; i < 300; ++i, ++tries) {
      auto damaged = bytes;
      const int flips = 1 + static_cast<int>(random() % 3);
      for (int f = 0; f < flips; ++f) damaged[random() % damaged.size()] ^= static_cast<std::byte>(1 + random() % 255);
      const auto back = kCoded.decode(damaged);
      // What gets through is for the checksum to catch; it still has to be safe to check, and to store again.
      if (!back || !validate(*back, 256)) {
        ++refused;
      } else {
        EXPECT_TRUE(kCoded.encode(*back).has_value());
      }
    }
  }
  EXPECT_GT(refused, tries / 3);
}

TEST(CodedTinMesh, SurvivesNoise) {
  std::mt19937 random(36);
  for (int i = 0; i < 4000; ++i) {
    std::vector<std::byte> noise(1 + random() % 300);
    for (auto& b : noise) b = static_cast<std::byte>(random());
    noise[0] = kTinCoded;
    if (i % 2 == 0 && noise.size() > 3) {
      noise[2] = std::byte{0};
      noise[3] = static_cast<std::byte>(random() % 64);
    }
    if (const auto mesh = kCoded.decode(noise)) (void)validate(*mesh, 1 << 20);
  }
  // Nothing but the least probable bits' codes, whatever the models make of them.
  for (const auto fill : {std::byte{0}, std::byte{0xff}}) {
    for (int form = 0; form < 64; ++form) {
      std::vector<std::byte> noise(200, fill);
      noise[0] = kTinCoded;
      noise[2] = std::byte{0};
      noise[3] = static_cast<std::byte>(form);
      EXPECT_FALSE(kCoded.decode(noise).has_value());
    }
  }
}

}  // namespace
}  // namespace tintree::codec
