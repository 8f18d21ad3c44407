#include "codec/tile_mesh.h"

#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "tests/codec/random_mesh.h"

namespace tintree::codec {
namespace {

TileMesh one_triangle() {
  TileMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 4, 5}, {4, 4, 9}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

TEST(TileMesh, AreaIsPositiveCounterClockwiseFromAbove) {
  // y runs southward: north-west, south-west, south-east is counter-clockwise.
  EXPECT_EQ(doubled_area({0, 0, 0}, {0, 4, 0}, {4, 4, 0}), 16);
  EXPECT_EQ(doubled_area({0, 0, 0}, {4, 4, 0}, {0, 4, 0}), -16);
  EXPECT_EQ(doubled_area({0, 0, 0}, {2, 2, 7}, {4, 4, 0}), 0);
}

TEST(TileMesh, AreaOfTheLargestTileDoesNotOverflow) {
  const std::int32_t far = 1 << 30;
  EXPECT_EQ(doubled_area({0, 0, 0}, {0, far, 0}, {far, far, 0}), std::int64_t{far} * far);
}

TEST(TileMesh, WhatIsRightPasses) {
  EXPECT_TRUE(validate(one_triangle(), 4).has_value());
  EXPECT_TRUE(validate(TileMesh{}, 4).has_value());
  std::mt19937 random(1);
  EXPECT_TRUE(validate(test::random_mesh(random, {.columns = 8, .rows = 8, .drop = 0.2, .split = 0.1}), 8).has_value());
}

TEST(TileMesh, AddressesReachFurtherWithFinerSteps) {
  TileMesh mesh = one_triangle();
  EXPECT_FALSE(validate(mesh, 3).has_value());
  mesh.xy_shift = -1;
  EXPECT_TRUE(validate(mesh, 2).has_value());
  mesh.xy_shift = 2;
  EXPECT_FALSE(validate(mesh, 15).has_value());
  EXPECT_TRUE(validate(mesh, 16).has_value());
}

TEST(TileMesh, EveryViolationIsRefused) {
  const std::vector<std::function<void(TileMesh&)>> violations = {
      [](TileMesh& m) { m.xy_shift = kMinXyShift - 1; },
      [](TileMesh& m) { m.xy_shift = kMaxXyShift + 1; },
      [](TileMesh& m) { m.z_offset = kMaxHeightOffset + 1; },
      [](TileMesh& m) { m.z_offset = -kMaxHeightOffset - 1; },
      [](TileMesh& m) { m.vertices[0].x = -1; },
      [](TileMesh& m) { m.vertices[0].y = -1; },
      [](TileMesh& m) { m.vertices[2].x = 5; },
      [](TileMesh& m) { m.vertices[2].y = 5; },
      [](TileMesh& m) { m.vertices[1].z = -1; },
      [](TileMesh& m) { m.vertices[1].z = kMaxHeightAddress + 1; },
      [](TileMesh& m) { m.triangles[0][1] = 3; },
      [](TileMesh& m) {
        m.triangles[0] = {0, 2, 1};
      },
      [](TileMesh& m) {
        m.triangles[0] = {0, 1, 1};
      },
      [](TileMesh& m) {
        m.vertices[2] = {0, 2, 9};
      },
  };
  for (std::size_t i = 0; i < violations.size(); ++i) {
    TileMesh mesh = one_triangle();
    violations[i](mesh);
    const auto checked = validate(mesh, 4);
    ASSERT_FALSE(checked.has_value()) << "violation " << i;
    EXPECT_EQ(checked.error().code, ErrorCode::kBadData);
  }
}

}  // namespace
}  // namespace tintree::codec
