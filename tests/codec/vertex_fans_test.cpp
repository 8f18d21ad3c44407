#include "codec/vertex_fans.h"

#include <gtest/gtest.h>

#include "tests/codec/random_mesh.h"

namespace tintree::codec {
namespace {

TEST(VertexFans, TwoTrianglesThatTouchInAPointComeApart) {
  TileMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 2, 1}, {1, 1, 2}, {2, 0, 3}, {2, 2, 4}};
  mesh.triangles = {{0, 1, 2}, {2, 4, 3}};
  const auto before = test::triangle_set(mesh);
  separate_fans(mesh);
  EXPECT_EQ(mesh.vertices.size(), 6U);
  EXPECT_NE(mesh.triangles[0][2], mesh.triangles[1][0]);
  EXPECT_EQ(test::triangle_set(mesh), before);
}

TEST(VertexFans, AWholeMeshStaysAsItIs) {
  std::mt19937 random(1);
  TileMesh mesh = test::random_mesh(random, {});
  const TileMesh before = mesh;
  separate_fans(mesh);
  EXPECT_EQ(mesh.vertices, before.vertices);
  EXPECT_EQ(mesh.triangles, before.triangles);
}

}  // namespace
}  // namespace tintree::codec
