#include "codec/right_triangle_code.h"

#include <cmath>
#include <functional>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "tests/codec/random_mesh.h"

namespace tintree::codec {
namespace {

std::int32_t height(std::int64_t x, std::int64_t y) {
  return static_cast<std::int32_t>(
      std::lround(5000 + 900 * std::sin(0.2 * static_cast<double>(x)) + 700 * std::cos(0.3 * static_cast<double>(y))));
}

/// Makes a mesh of triangles named by their corners' samples.
class MeshMaker {
 public:
  explicit MeshMaker(std::int64_t z_offset) { mesh_.z_offset = z_offset; }

  void add(std::array<std::array<std::int32_t, 2>, 3> corners) {
    Triangle t{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [at, fresh] = vertex_of_.try_emplace(corners[k], static_cast<std::uint32_t>(mesh_.vertices.size()));
      if (fresh) mesh_.vertices.push_back({corners[k][0], corners[k][1], height(corners[k][0], corners[k][1])});
      t[k] = at->second;
    }
    mesh_.triangles.push_back(t);
  }
  TileMesh take() { return std::move(mesh_); }

 private:
  TileMesh mesh_;
  std::map<std::array<std::int32_t, 2>, std::uint32_t> vertex_of_;
};

/// Every sample a vertex, every cell cut from north-west to south-east, as the surface itself.
TileMesh surface(int cells, const std::function<bool(int, int)>& exists) {
  MeshMaker maker(-1234567);
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      if (!exists(x, y) || !exists(x + 1, y + 1)) continue;
      if (exists(x, y + 1)) maker.add({{{x, y}, {x, y + 1}, {x + 1, y + 1}}});
      if (exists(x + 1, y)) maker.add({{{x, y}, {x + 1, y + 1}, {x + 1, y}}});
    }
  }
  return maker.take();
}

/// Two triangles a square, their diagonals alternating.
TileMesh squares(int cells, int square) {
  MeshMaker maker(99);
  for (int y = 0; y < cells; y += square) {
    for (int x = 0; x < cells; x += square) {
      const int e = x + square;
      const int s = y + square;
      if ((x / square + y / square) % 2 == 0) {
        maker.add({{{x, y}, {e, s}, {e, y}}});
        maker.add({{{x, y}, {x, s}, {e, s}}});
      } else {
        maker.add({{{x, s}, {e, y}, {x, y}}});
        maker.add({{{x, s}, {e, s}, {e, y}}});
      }
    }
  }
  return maker.take();
}

/// In quarters of a step; not exact, as a patch is not.
std::int64_t good_guess(std::int64_t x, std::int64_t y) {
  return 4 * (std::int64_t{height(x, y)} - 1234567) + (x * y) % 7;
}
std::int64_t no_guess(std::int64_t, std::int64_t) { return 0; }

std::size_t expect_kept(const TileMesh& mesh, std::int64_t cells, const HeightGuess& guess) {
  const auto bytes = encode_right_triangles(mesh, cells, guess);
  EXPECT_TRUE(bytes.has_value()) << bytes.error().text();
  if (!bytes) return 0;
  const auto decoded = decode_right_triangles(*bytes, cells, guess);
  EXPECT_TRUE(decoded.has_value()) << decoded.error().text();
  if (!decoded) return 0;
  EXPECT_TRUE(validate(*decoded, cells).has_value());
  const auto placed = [](TileMesh m) {
    for (GridVertex& v : m.vertices) {
      v = {v.x << m.xy_shift, v.y << m.xy_shift, static_cast<std::int32_t>(v.z + m.z_offset)};
    }
    m.xy_shift = 0;
    m.z_offset = 0;
    return test::triangle_set(m);
  };
  EXPECT_EQ(placed(*decoded), placed(mesh));
  return bytes->size();
}

TEST(RightTriangleCode, TheWholeSurfaceComesBack) {
  const auto all = [](int, int) { return true; };
  for (const int cells : {8, 16, 32, 64}) {
    const std::size_t guessed = expect_kept(surface(cells, all), cells, good_guess);
    EXPECT_LT(guessed, expect_kept(surface(cells, all), cells, no_guess));
  }
}

TEST(RightTriangleCode, BareSquaresComeBackOnACoarseGrid) {
  const auto bytes = encode_right_triangles(squares(256, 16), 256, good_guess);
  ASSERT_TRUE(bytes.has_value());
  EXPECT_EQ(decode_right_triangles(*bytes, 256, good_guess)->xy_shift, 4);
  expect_kept(squares(256, 16), 256, no_guess);
}

TEST(RightTriangleCode, HolesComeBackWhereTheyAre) {
  std::mt19937 random(11);
  for (const double share : {0.02, 0.3, 0.8}) {
    std::map<std::array<int, 2>, bool> there;
    const auto exists = [&](int x, int y) {
      const auto [at, fresh] = there.try_emplace({x, y}, false);
      if (fresh) at->second = std::bernoulli_distribution(1 - share)(random);
      return at->second;
    };
    expect_kept(surface(32, exists), 32, good_guess);
  }
}

TEST(RightTriangleCode, RefusesOtherMeshes) {
  MeshMaker maker(0);
  maker.add({{{0, 0}, {1, 5}, {3, 1}}});
  const TileMesh mesh = maker.take();
  EXPECT_FALSE(encode_right_triangles(mesh, 8, no_guess).has_value());
}

TEST(RightTriangleCode, DamagedBytesAreRefusedOrAMesh) {
  const auto bytes = encode_right_triangles(surface(32, [](int x, int y) { return x != y; }), 32, good_guess);
  ASSERT_TRUE(bytes.has_value());
  std::mt19937 random(4);
  for (int i = 0; i < 200; ++i) {
    std::vector<std::byte> damaged = *bytes;
    damaged[random() % damaged.size()] ^= static_cast<std::byte>(1 + random() % 255);
    damaged.resize(damaged.size() - random() % (damaged.size() / 2));
    const auto mesh = decode_right_triangles(damaged, 32, good_guess);
    if (mesh) static_cast<void>(validate(*mesh, 32));
  }
}

}  // namespace
}  // namespace tintree::codec
