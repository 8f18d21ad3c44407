/// Repaired collapses keep the bound, and those that cannot be repaired leave no trace.

#include "simplify/collapse_repair.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "simplify/edge_collapse.h"
#include "simplify/right_triangle_mesh.h"
#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

using test::Terrain;

constexpr std::int64_t kCells = 64;

/// A simplified tile whose edges can be collapsed by hand.
class Simplified {
 public:
  Simplified(unsigned seed, double bound_m)
      : terrain_(test::make_terrain(kCells + 1, kCells + 1, test::rough_hills(20, 1, 0, seed))),
        bound_m_(bound_m),
        view_(*terrain_.surface),
        distance_(view_, 0, 0) {
    RightTriangleMesh start(view_, {kCells, bound_m, {bound_m / 4}}, 0, 0);
    StartMesh tile = start.tile();
    spec_.heights = tile.heights;
    spec_.bound_m = tested_bound_m(*terrain_.surface, {0, 0, kCells, kCells}, bound_m);
    mesh_.build(std::move(tile.vertices), tile.triangles);
    for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) {
      if (mesh_.alive(v) && mesh_.on_outline(v)) mesh_.kinds[static_cast<std::size_t>(v)] = VertexKind::kLocked;
    }
    EdgeCollapse().run(mesh_, distance_, spec_);
  }

  /// The largest error of the whole mesh; fails the test where a triangle is folded.
  double error_m() const {
    codec::TreeLayout layout;
    layout.columns = layout.rows = kCells + 1;
    layout.tile_cells = kCells;
    layout.z_step_m = {spec_.heights.step_m};
    codec::TileMesh tile;
    tile.z_offset = spec_.heights.origin;
    for (const LatticeVertex& v : mesh_.vertices) tile.vertices.push_back({v.x, v.y, v.z});
    for (std::int32_t h = 0; h < mesh_.half_edge_count(); h += 3) {
      if (!mesh_.triangle_alive(h)) continue;
      codec::Triangle t{};
      for (std::int32_t k = 0; k < 3; ++k)
        t[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(mesh_.origin(h + k));
      EXPECT_GT(codec::doubled_area(tile.vertices[t[0]], tile.vertices[t[1]], tile.vertices[t[2]]), 0) << "folded";
      tile.triangles.push_back(t);
    }
    return test::overlay(terrain_.grid, layout, {}, tile).max_m;
  }

  std::set<std::int32_t> neighbours(std::int32_t v) const {
    std::set<std::int32_t> out;
    for (const Ring::Side& s : star(v)) out.insert({s.from, s.to});
    return out;
  }

  bool may_collapse(std::int32_t h) const {
    const std::int32_t a = mesh_.origin(h);
    const std::int32_t b = mesh_.target(h);
    if (!is_free(a) || !is_free(b)) return false;
    std::vector<std::int32_t> shared;
    std::ranges::set_intersection(neighbours(a), neighbours(b), std::back_inserter(shared));
    return shared.size() == 2;
  }

  /// What will surround the merged vertex.
  Ring ring_of(std::int32_t gone, std::int32_t kept) const {
    Ring ring;
    for (const auto& [v, other] : {std::pair{gone, kept}, {kept, gone}}) {
      for (const Ring::Side& s : star(v)) {
        if (s.from != other && s.to != other) ring.sides.push_back(s);
      }
    }
    for (const Ring::Side& s : ring.sides) ring.spokes.push_back(s.from);
    return ring;
  }

  bool repair(CollapseRepair& repair, std::int32_t h) {
    const std::int32_t gone = mesh_.origin(h);
    const std::int32_t kept = mesh_.target(h);
    StarFit fit(mesh_, distance_, spec_);
    LatticeVertex merged = mesh_.vertex(kept);
    const std::vector<LatticeVertex> before = mesh_.vertices;
    if (!repair.run(mesh_, fit, gone, kept, ring_of(gone, kept), merged)) {
      EXPECT_EQ(mesh_.vertices, before) << "a failure moved a vertex";
      return false;
    }
    std::set<std::int32_t> expected(repair.moved().begin(), repair.moved().end());
    expected.insert({gone, kept});
    for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) {
      const bool same = mesh_.vertex(v) == before[static_cast<std::size_t>(v)];
      EXPECT_TRUE(same || expected.contains(v)) << "moved without saying so";
    }
    mesh_.collapse(h, kept);
    mesh_.vertex(kept) = merged;
    return true;
  }

  HalfEdgeMesh& mesh() { return mesh_; }
  double bound_m() const { return bound_m_; }

 private:
  bool is_free(std::int32_t v) const { return mesh_.kinds[static_cast<std::size_t>(v)] == VertexKind::kFree; }

  std::vector<Ring::Side> star(std::int32_t v) const {
    std::vector<Ring::Side> out;
    for (std::int32_t h = 0; h < mesh_.half_edge_count(); ++h) {
      if (mesh_.triangle_alive(h) && mesh_.origin(h) == v) {
        out.push_back({mesh_.target(h), mesh_.origin(HalfEdgeMesh::previous(h))});
      }
    }
    return out;
  }

  Terrain terrain_;
  double bound_m_;
  SurfaceView view_;
  SurfaceDistance distance_;
  CollapseSpec spec_;
  HalfEdgeMesh mesh_;
};

TEST(CollapseRepair, KeepsTheBoundOrChangesNothing) {
  int repaired = 0;
  int with_neighbours = 0;
  int refused = 0;
  for (unsigned seed = 0; seed < 3; ++seed) {
    Simplified tile(seed, 2);
    ASSERT_LE(tile.error_m(), tile.bound_m());
    CollapseRepair repair;
    for (std::int32_t h = 0; h < tile.mesh().half_edge_count(); ++h) {
      if (!tile.mesh().triangle_alive(h) || !tile.may_collapse(h)) continue;
      if (!tile.repair(repair, h)) {
        ++refused;
        continue;
      }
      ++repaired;
      with_neighbours += repair.moved().empty() ? 0 : 1;
      ASSERT_LE(tile.error_m(), tile.bound_m());
      if (testing::Test::HasFailure()) return;
    }
  }
  EXPECT_GT(repaired, 20);
  EXPECT_GT(with_neighbours, 5);
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace tintree::simplify
