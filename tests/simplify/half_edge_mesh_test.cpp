#include "simplify/half_edge_mesh.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace tintree::simplify {
namespace {

using Triangles = std::vector<std::array<std::int32_t, 3>>;

/// A grid of n x n cells, each cut into two triangles that are kept with a chance.
struct Grid {
  std::vector<LatticeVertex> vertices;
  Triangles triangles;

  Grid(std::int32_t n, double keep, std::mt19937& random) {
    for (std::int32_t y = 0; y <= n; ++y) {
      for (std::int32_t x = 0; x <= n; ++x) vertices.push_back({x, y, 0});
    }
    std::uniform_real_distribution<double> chance(0, 1);
    for (std::int32_t y = 0; y < n; ++y) {
      for (std::int32_t x = 0; x < n; ++x) {
        const std::int32_t nw = y * (n + 1) + x;
        const std::int32_t sw = nw + n + 1;
        if (chance(random) < keep) triangles.push_back({nw, sw, sw + 1});
        if (chance(random) < keep) triangles.push_back({nw, sw + 1, nw + 1});
      }
    }
    std::ranges::shuffle(triangles, random);
  }
};

/// All half-edges that leave a vertex, found by asking every one.
std::set<std::int32_t> leaving(const HalfEdgeMesh& mesh, std::int32_t v) {
  std::set<std::int32_t> out;
  for (std::int32_t h = 0; h < mesh.half_edge_count(); ++h) {
    if (mesh.triangle_alive(h) && mesh.origin(h) == v) out.insert(h);
  }
  return out;
}

/// The half-edges that rotate() visits from outgoing().
std::set<std::int32_t> rotated(const HalfEdgeMesh& mesh, std::int32_t v) {
  std::set<std::int32_t> out;
  for (std::int32_t h = mesh.outgoing(v); h != kNone && out.insert(h).second;) h = mesh.rotate(h);
  return out;
}

void expect_sound(const HalfEdgeMesh& mesh) {
  for (std::int32_t h = 0; h < mesh.half_edge_count(); ++h) {
    if (!mesh.triangle_alive(h)) continue;
    EXPECT_TRUE(mesh.alive(mesh.origin(h)));
    const std::int32_t twin = mesh.twin(h);
    if (twin == kNone) continue;
    EXPECT_TRUE(mesh.triangle_alive(twin));
    EXPECT_EQ(mesh.twin(twin), h);
    EXPECT_EQ(mesh.origin(twin), mesh.target(h));
    EXPECT_EQ(mesh.target(twin), mesh.origin(h));
  }
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    const auto all = leaving(mesh, v);
    ASSERT_EQ(mesh.alive(v), !all.empty()) << v;
    if (!mesh.alive(v)) continue;
    EXPECT_EQ(rotated(mesh, v), all) << "one fan from the outgoing half-edge: " << v;
    const bool open = std::ranges::any_of(all, [&](std::int32_t h) { return mesh.twin(h) == kNone; });
    EXPECT_EQ(mesh.on_outline(v), open) << "the clockwise-most has no twin: " << v;
  }
}

/// Vertices less edges plus triangles.
std::int64_t euler(const HalfEdgeMesh& mesh) {
  std::int64_t doubled = 0;
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) doubled += mesh.alive(v) ? 2 : 0;
  for (std::int32_t h = 0; h < mesh.half_edge_count(); ++h) {
    if (!mesh.triangle_alive(h)) continue;
    doubled -= mesh.twin(h) == kNone ? 2 : 1;
    if (h % 3 == 0) doubled += 2;
  }
  return doubled / 2;
}

std::set<std::int32_t> neighbours(const HalfEdgeMesh& mesh, std::int32_t v) {
  std::set<std::int32_t> out;
  for (const std::int32_t h : leaving(mesh, v)) {
    out.insert(mesh.target(h));
    out.insert(mesh.origin(HalfEdgeMesh::previous(h)));
  }
  return out;
}

/// Whether the result of a collapse is a mesh again.
bool may_collapse(const HalfEdgeMesh& mesh, std::int32_t h) {
  const std::int32_t a = mesh.origin(h);
  const std::int32_t b = mesh.target(h);
  const bool inside = mesh.twin(h) != kNone;
  if (inside && mesh.on_outline(a) && mesh.on_outline(b)) return false;
  if (leaving(mesh, a).size() + leaving(mesh, b).size() == 2) return false;  // a lone triangle
  const auto around_a = neighbours(mesh, a);
  const auto around_b = neighbours(mesh, b);
  std::vector<std::int32_t> shared;
  std::ranges::set_intersection(around_a, around_b, std::back_inserter(shared));
  return shared.size() == (inside ? 2U : 1U);
}

TEST(HalfEdgeMesh, BuildsOneTriangle) {
  HalfEdgeMesh mesh;
  const Triangles one{{0, 1, 2}};
  mesh.build({{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {5, 5, 5}}, one);
  expect_sound(mesh);
  EXPECT_EQ(mesh.half_edge_count(), 3);
  EXPECT_FALSE(mesh.alive(3));
  EXPECT_EQ(mesh.target(mesh.outgoing(0)), 1);
  EXPECT_EQ(mesh.kinds.size(), 4U);
}

TEST(HalfEdgeMesh, MatchesEverySharedSide) {
  std::mt19937 random(1);
  const Grid grid(9, 1, random);
  HalfEdgeMesh mesh;
  mesh.build(grid.vertices, grid.triangles);
  expect_sound(mesh);
  EXPECT_EQ(mesh.vertex_count(), 100);
  EXPECT_EQ(euler(mesh), 1);
  for (std::int32_t v = 0; v < 100; ++v) {
    const LatticeVertex& p = mesh.vertices[static_cast<std::size_t>(v)];
    EXPECT_EQ(mesh.on_outline(v), p.x == 0 || p.y == 0 || p.x == 9 || p.y == 9);
  }
}

TEST(HalfEdgeMesh, SplitsABowTie) {
  HalfEdgeMesh mesh;
  const Triangles two{{0, 1, 2}, {2, 3, 4}};
  mesh.build({{0, 0, 0}, {0, 2, 0}, {1, 1, 7}, {2, 2, 0}, {2, 0, 0}}, two);
  ASSERT_EQ(mesh.vertex_count(), 6);
  expect_sound(mesh);
  EXPECT_EQ(mesh.vertices[5].x, 1);
  EXPECT_EQ(mesh.vertices[5].z, 7);
  EXPECT_NE(mesh.origin(2), mesh.origin(3));
}

TEST(HalfEdgeMesh, SplitsAllFansOfAHoledGrid) {
  std::mt19937 random(2);
  for (const double keep : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    const Grid grid(12, keep, random);
    HalfEdgeMesh mesh;
    mesh.build(grid.vertices, grid.triangles);
    expect_sound(mesh);
    for (std::size_t t = 0; t < grid.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& before = grid.vertices[static_cast<std::size_t>(grid.triangles[t][k])];
        const auto& after = mesh.vertices[static_cast<std::size_t>(mesh.origin(static_cast<std::int32_t>(3 * t + k)))];
        EXPECT_TRUE(before.x == after.x && before.y == after.y && before.z == after.z);
      }
    }
  }
}

TEST(HalfEdgeMesh, BuildsAgainOverAnOldMesh) {
  std::mt19937 random(3);
  HalfEdgeMesh mesh;
  for (const std::int32_t n : {10, 3, 7}) {
    const Grid grid(n, 0.8, random);
    mesh.build(grid.vertices, grid.triangles);
    expect_sound(mesh);
    EXPECT_EQ(mesh.half_edge_count(), static_cast<std::int32_t>(3 * grid.triangles.size()));
  }
}

TEST(HalfEdgeMesh, RandomCollapsesKeepItSound) {
  std::mt19937 random(4);
  for (const double keep : {1.0, 0.9, 0.6, 0.3}) {
    const Grid grid(8, keep, random);
    HalfEdgeMesh mesh;
    mesh.build(grid.vertices, grid.triangles);
    const std::int64_t before = euler(mesh);
    int collapses = 0;
    for (int round = 0; round < 1500; ++round) {
      const auto h = static_cast<std::int32_t>(random() % static_cast<unsigned>(mesh.half_edge_count()));
      if (!mesh.triangle_alive(h) || !may_collapse(mesh, h)) continue;
      const std::int32_t kept = random() % 2 == 0 ? mesh.origin(h) : mesh.target(h);
      const std::int32_t gone = kept == mesh.origin(h) ? mesh.target(h) : mesh.origin(h);
      mesh.collapse(h, kept);
      EXPECT_TRUE(mesh.alive(kept));
      EXPECT_FALSE(mesh.alive(gone));
      ++collapses;
      expect_sound(mesh);
      ASSERT_EQ(euler(mesh), before);
      if (testing::Test::HasFailure()) return;
    }
    EXPECT_GT(collapses, 10);
  }
}

/// Twice the signed area, positive counter-clockwise seen from above (y runs southward).
std::int64_t doubled_area(const LatticeVertex& a, const LatticeVertex& b, const LatticeVertex& c) {
  return std::int64_t{c.x - a.x} * (b.y - a.y) - std::int64_t{b.x - a.x} * (c.y - a.y);
}

TEST(HalfEdgeMesh, RandomFlipsKeepItSound) {
  std::mt19937 random(5);
  for (const double keep : {1.0, 0.9, 0.6, 0.3}) {
    const Grid grid(8, keep, random);
    HalfEdgeMesh mesh;
    mesh.build(grid.vertices, grid.triangles);
    const std::int64_t before = euler(mesh);
    int flips = 0;
    for (int round = 0; round < 1500; ++round) {
      const auto h = static_cast<std::int32_t>(random() % static_cast<unsigned>(mesh.half_edge_count()));
      if (mesh.twin(h) == kNone) continue;
      const std::int32_t a = mesh.origin(h);
      const std::int32_t b = mesh.target(h);
      const std::int32_t left = mesh.origin(HalfEdgeMesh::previous(h));
      const std::int32_t right = mesh.origin(HalfEdgeMesh::previous(mesh.twin(h)));
      if (doubled_area(mesh.vertex(left), mesh.vertex(right), mesh.vertex(b)) <= 0 ||
          doubled_area(mesh.vertex(left), mesh.vertex(a), mesh.vertex(right)) <= 0) {
        continue;
      }
      mesh.flip(h);
      ++flips;
      expect_sound(mesh);
      EXPECT_EQ(euler(mesh), before);
      EXPECT_TRUE(neighbours(mesh, left).contains(right));
      for (std::int32_t t = 0; t < mesh.half_edge_count(); t += 3) {
        EXPECT_GT(
            doubled_area(mesh.vertex(mesh.origin(t)), mesh.vertex(mesh.origin(t + 1)), mesh.vertex(mesh.origin(t + 2))),
            0);
      }
      if (testing::Test::HasFailure()) return;
    }
    EXPECT_GT(flips, 10);
  }
}

}  // namespace
}  // namespace tintree::simplify
