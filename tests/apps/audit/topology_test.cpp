#include "apps/audit/topology.h"

#include <gtest/gtest.h>

#include "tests/apps/audit/measure_support.h"
#include "tests/apps/audit/random_tin.h"

namespace tintree::test {
namespace {

audit::TileSurface surface_of(const codec::TileMesh& mesh) {
  codec::TreeLayout layout;
  layout.columns = 9;
  layout.rows = 9;
  layout.tile_cells = 8;
  layout.z_step_m = {1};
  layout.leaf_error_m = 1;
  return audit::place(layout, {0, 0, 0}, mesh);
}

const codec::TileMesh kSquare{0, 0, {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {8, 8, 0}}, {{0, 2, 3}, {0, 3, 1}}};

TEST(Topology, AcceptsManifolds) {
  EXPECT_EQ(audit::check_topology(surface_of(kSquare)).count, 0U);
  const RasterFixture dem({.columns = 30, .rows = 30},
                          [](int c, int r) { return c % 7 == 3 && r % 5 == 2 ? kMissing : hills(c, r); });
  const TestTree tree = make_regular_tree(dem.path, {.tile_cells = 32});
  EXPECT_EQ(audit::check_topology(audit::place(tree.manifest.layout, {0, 0, 0}, tree.mesh({0, 0, 0}))).count, 0U);
}

TEST(Topology, FindsADuplicateTriangle) {
  codec::TileMesh mesh = kSquare;
  mesh.triangles.push_back({2, 3, 0});
  EXPECT_GT(audit::check_topology(surface_of(mesh)).count, 0U);
  EXPECT_GT(surface_of(mesh).overused_edges, 0U);
}

TEST(Topology, FindsAThirdTriangleAtAnEdge) {
  codec::TileMesh mesh = kSquare;
  mesh.vertices.push_back({1, 7, 0});
  mesh.triangles.push_back({0, 4, 3});
  EXPECT_GT(audit::check_topology(surface_of(mesh)).count, 0U);
}

TEST(Topology, FindsAVertexThatJoinsTwoFans) {
  const codec::TileMesh mesh{0, 0, {{0, 0, 0}, {0, 4, 0}, {4, 4, 0}, {4, 8, 0}, {8, 8, 0}}, {{0, 1, 2}, {2, 3, 4}}};
  EXPECT_GT(audit::check_topology(surface_of(mesh)).count, 0U);
}

TEST(Topology, FindsAnUnusedVertex) {
  codec::TileMesh mesh = kSquare;
  mesh.vertices.push_back({1, 1, 0});
  EXPECT_GT(audit::check_topology(surface_of(mesh)).count, 0U);
}

}  // namespace
}  // namespace tintree::test
