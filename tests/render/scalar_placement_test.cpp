#include "render/scalar_placement.h"

#include <array>
#include <cstdint>
#include <random>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <gtest/gtest.h>

#include "codec/grid_frame.h"

namespace tintree::render {
namespace {

glm::vec3 on_side(const ScalarPlacement& at, glm::ivec3 address) {
  return at.lattice_to_eye * glm::vec4(at.on_lattice(address), 1);
}

struct Tile {
  codec::GridFrame frame;
  cache::QuantizedFormat format;
};

/// A tile of some stride, height origin and quantiser.
Tile random_tile(std::mt19937& random, const codec::TreeLayout& layout, std::uint32_t x) {
  const auto below = [&](unsigned n) { return static_cast<int>(random() % n); };
  codec::TileMesh mesh;
  mesh.xy_shift = below(4);
  mesh.z_offset = 700 + below(300);
  Tile out{codec::GridFrame(layout, {2, x, 1}, mesh), {}};
  out.format.low = below(50);
  out.format.step = 1 + below(20);
  return out;
}

glm::dvec3 from_eye(const Tile& tile, glm::ivec3 address, const std::array<double, 3>& eye) {
  const auto at = tile.frame.world({address.x, address.y, address.z});
  return {at[0] - eye[0], at[1] - eye[1], at[2] - eye[2]};
}

TEST(ScalarPlacement, SharedVerticesAreTheSameFloatsWhateverTheTiles) {
  codec::TreeLayout layout;
  layout.columns = layout.rows = 1025;
  layout.leaf_level = 2;
  layout.dx_m = 28.7;
  layout.dy_m = 30.92;
  layout.axes = {{0.8, 0.6}, {0.6, -0.8}};
  layout.z_step_m = {0.4, 0.2, 0.137};
  std::mt19937 random(1);
  int apart = 0;  // vertices that the tiles' own matrices put in two places
  for (int i = 0; i < 300; ++i) {
    const auto metres = [&](double most) { return most * (static_cast<double>(random()) / 4294967296.0 - 0.5); };
    const std::array<double, 3> eye{metres(60000), metres(60000), metres(i < 250 ? 5000 : 4e8)};
    const Tile west = random_tile(random, layout, 0);
    const Tile east = random_tile(random, layout, 1);
    const auto cells = static_cast<std::int32_t>(layout.cells_across(2));
    for (std::int32_t row = 0; row <= cells; row += 8) {
      const std::int64_t height = 1000 + static_cast<std::int64_t>(random() % 10000);
      const auto address = [&](const Tile& tile, std::int32_t column) {
        return glm::ivec3(column >> tile.frame.xy_shift, row >> tile.frame.xy_shift, height - tile.frame.z_offset);
      };
      const glm::ivec3 a = address(west, cells);
      const glm::ivec3 b = address(east, 0);
      const glm::vec3 p = on_side(place_scalar(west.frame, west.format, eye), a);
      EXPECT_EQ(p, on_side(place_scalar(east.frame, east.format, eye), b));
      const glm::dvec3 truth = from_eye(west, a, eye);
      EXPECT_LE(glm::length(glm::dvec3(p) - truth), 1e-6 * (glm::length(truth) + 1));
      apart += glm::mat4(glm::make_mat4(west.frame.matrix(eye).data())) * glm::vec4(a, 1) ==
                       glm::mat4(glm::make_mat4(east.frame.matrix(eye).data())) * glm::vec4(b, 1)
                   ? 0
                   : 1;
    }
  }
  EXPECT_GT(apart, 1000) << "there was nothing to stitch";
}

TEST(ScalarPlacement, InsideOneMatrixDequantizes) {
  codec::TreeLayout layout;
  layout.columns = layout.rows = 1025;
  layout.leaf_level = 2;
  layout.dx_m = layout.dy_m = 5;
  layout.z_step_m = {0.4, 0.2, 0.1};
  std::mt19937 random(2);
  const std::array<double, 3> eye{1000, -2000, 300};
  for (int i = 0; i < 100; ++i) {
    const Tile tile = random_tile(random, layout, 1);
    const glm::ivec3 word(random() % 30, random() % 30, random() % 500);
    const glm::vec3 p(place_scalar(tile.frame, tile.format, eye).index_to_eye * glm::vec4(word, 1));
    const glm::dvec3 truth = from_eye(tile, {word.x, word.y, tile.format.low + tile.format.step * word.z}, eye);
    EXPECT_LE(glm::length(glm::dvec3(p) - truth), 1e-6 * (glm::length(truth) + 1));
  }
}

}  // namespace
}  // namespace tintree::render
