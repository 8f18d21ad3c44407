#include "codec/split_fans.h"

#include <gtest/gtest.h>

namespace tintree::codec {
namespace {

TEST(SplitFans, RepeatVerticesWhereFansOnlyTouch) {
  // Two triangles that touch at vertex 0, and a third beside the second.
  TileMesh mesh;
  mesh.vertices = {{4, 4, 1}, {0, 4, 2}, {4, 8, 3}, {8, 4, 4}, {4, 0, 5}, {0, 0, 6}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}, {0, 4, 5}};
  split_fans(mesh);
  ASSERT_EQ(mesh.vertices.size(), 7U);
  EXPECT_EQ(mesh.vertices[6], mesh.vertices[0]);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {6, 3, 4}, {6, 4, 5}}));
}

TEST(SplitFans, LeaveWholeFansAlone) {
  // A closed fan round vertex 0; each of the others has an open one, whose first triangle comes last.
  TileMesh mesh;
  mesh.vertices = {{1, 1, 0}, {2, 0, 0}, {0, 0, 0}, {0, 2, 0}, {2, 2, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 0, 2}, {0, 3, 4}, {4, 1, 0}};
  const TileMesh before = mesh;
  split_fans(mesh);
  EXPECT_EQ(mesh.vertices, before.vertices);
  EXPECT_EQ(mesh.triangles, before.triangles);
}

}  // namespace
}  // namespace tintree::codec
