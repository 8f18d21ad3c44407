/// Two tiles at a side make the same vertices there, each on its own.

#include "simplify/border_ribbon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "simplify/tin_maker.h"
#include "tests/simplify/support.h"
#include "tests/support/adversarial_terrain.h"

namespace tintree::simplify {
namespace {

using codec::TileId;
using codec::TileMesh;
using test::Terrain;

/// An edge along a side: two places along it, in samples, and the heights there.
struct SideEdge {
  double from;
  double to;
  double from_m;
  double to_m;

  friend bool operator==(const SideEdge&, const SideEdge&) = default;
};

/// Edges by the unit cells along the side that they span.
using SideEdges = std::map<std::int64_t, SideEdge>;

/// The mesh's edges on the line column = `line` (southward) or row = `line`.
SideEdges edges_on(const codec::TreeLayout& layout, const TileId& id, const TileMesh& mesh, bool southward,
                   std::int64_t line) {
  const codec::GridFrame frame(layout, id, mesh);
  SideEdges out;
  const auto across = [&](const codec::GridVertex& v) { return southward ? frame.column(v.x) : frame.row(v.y); };
  const auto along = [&](const codec::GridVertex& v) { return southward ? frame.row(v.y) : frame.column(v.x); };
  for (const codec::Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const codec::GridVertex* a = &mesh.vertices[t[k]];
      const codec::GridVertex* b = &mesh.vertices[t[(k + 1) % 3]];
      if (across(*a) != static_cast<double>(line) || across(*b) != static_cast<double>(line)) continue;
      if (along(*a) > along(*b)) std::swap(a, b);
      const SideEdge edge{along(*a), along(*b), frame.height_m(a->z), frame.height_m(b->z)};
      for (auto i = static_cast<std::int64_t>(edge.from); static_cast<double>(i) < edge.to; ++i) {
        EXPECT_TRUE(out.emplace(i, edge).second) << "two edges over one stretch of the side";
      }
    }
  }
  return out;
}

/// How often neighbours met, to know that the comparison was one.
struct Met {
  int stretches = 0;
  int longer_than_a_cell = 0;
};

void compare_side(const codec::TreeLayout& layout, const TileId& a, const TileMesh& mesh_a, const TileId& b,
                  const TileMesh& mesh_b, Met& met) {
  const bool southward = a.y == b.y;
  const std::int64_t line = (southward ? std::int64_t{b.x} : std::int64_t{b.y}) * layout.cells_across(a.level);
  const SideEdges left = edges_on(layout, a, mesh_a, southward, line);
  const SideEdges right = edges_on(layout, b, mesh_b, southward, line);
  for (const auto& [cell, edge] : left) {
    const auto other = right.find(cell);
    if (other == right.end()) continue;
    EXPECT_TRUE(edge == other->second) << a.text() << " and " << b.text() << " differ at " << cell << ": " << edge.from
                                       << ".." << edge.to << " and " << other->second.from << ".." << other->second.to;
    ++met.stretches;
    met.longer_than_a_cell += edge.to - edge.from > 1 ? 1 : 0;
  }
}

/// All sides of all levels; also that the line keeps half of the bound.
Met expect_equal_sides(const Terrain& terrain, int tile_cells, double error_m) {
  const codec::TreeLayout layout = test::make_layout(terrain, tile_cells, error_m);
  TinMaker maker(*terrain.surface, layout);
  std::map<std::int64_t, TileMesh> tiles;
  for (const TileId& id : test::tiles_of(layout)) {
    auto mesh = maker.make(id);
    EXPECT_TRUE(mesh.has_value());
    if (!mesh || mesh->triangles.empty()) continue;
    const double step = layout.z_step_m[static_cast<std::size_t>(id.level)];
    EXPECT_LE(test::overlay(terrain.grid, layout, id, *mesh).border_max_m, layout.bound_m(id.level) / 2 + step / 2);
    tiles.emplace(id.key(), std::move(*mesh));
  }
  Met met;
  for (const auto& [key, mesh] : tiles) {
    const TileId id = TileId::from_key(key);
    for (const TileId& next : {TileId{id.level, id.x + 1, id.y}, TileId{id.level, id.x, id.y + 1}}) {
      const auto other = tiles.find(next.key());
      if (other != tiles.end()) compare_side(layout, id, mesh, next, other->second, met);
    }
  }
  return met;
}

TEST(BorderRibbon, NeighboursAgreeOnRandomTerrain) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    const Terrain terrain = test::make_terrain(129, 129, test::rough_hills(30, 1, 0, seed));
    const Met met = expect_equal_sides(terrain, 16, 0.3 * std::pow(2.0, seed));
    EXPECT_GE(met.stretches, 2 * 128 * 7);
    EXPECT_GT(met.longer_than_a_cell, 0);
  }
}

TEST(BorderRibbon, NeighboursAgreeAtHoles) {
  // From single missing samples to islands; with tiles of 8 cells many touch sides and corners.
  for (unsigned seed = 0; seed < 12; ++seed) {
    const double holes = 0.01 * std::pow(2.0, seed % 6);
    const Terrain terrain = test::make_terrain(97, 66, test::rough_hills(20, 1, holes, seed));
    const Met met = expect_equal_sides(terrain, 8, seed % 2 == 0 ? 1 : 8);
    EXPECT_GT(met.stretches, 100);
    EXPECT_GT(met.longer_than_a_cell, 0);
  }
}

TEST(BorderRibbon, NeighboursAgreeAtLargeHoles) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    const auto hills = test::rough_hills(20, 0.5, 0, seed);
    const auto height = [&](int c, int r) {
      return test::noise(c / 6, r / 6, seed) < 0.3 ? test::kMissing : hills(c, r);
    };
    expect_equal_sides(test::make_terrain(97, 97, height), 16, 2);
  }
}

TEST(BorderRibbon, NeighboursAgreeAtCliffs) {
  for (const int where : {15, 16, 17, 31, 32}) {
    expect_equal_sides(
        test::make_terrain(65, 65,
                           [=](int c, int r) { return (c >= where ? 100.0 : 0.0) + (r >= where ? 40.0 : 0.0); }),
        16, 1);
    expect_equal_sides(
        test::make_terrain(65, 65,
                           [=](int c, int r) { return (c + r >= 2 * where ? 200.0 : 0.0) + test::hills(c, r, 5); }),
        16, 1);
  }
}

TEST(BorderRibbon, NeighboursAgreeOnEveryShape) {
  for (const test::AdversarialTerrain& shape : test::everyday_terrains()) {
    SCOPED_TRACE(shape.name);
    expect_equal_sides(test::make_terrain(shape.columns, shape.rows, shape.height), 16, 1.5);
  }
}

TEST(BorderRibbon, WhatLiesFarOffDoesNotMoveTheSide) {
  // The neighbours' height ranges, and with them their rounding guards, differ beyond measure.
  const auto hills = test::rough_hills(4, 0.2, 0);
  const auto with_tower = [&](int c, int r) { return c == 384 && r == 96 ? 100000.0 : hills(c, r); };
  const Terrain terrain = test::make_terrain(513, 257, with_tower);
  for (const double error_m : {0.12, 0.5}) {
    const Met met = expect_equal_sides(terrain, 256, error_m);
    EXPECT_GT(met.longer_than_a_cell, 0);
  }
}

TEST(BorderRibbon, NeighboursAgreeOnSamplesThatBlocksRoundApart) {
  const auto hills = test::rough_hills(4, 1, 0);
  const auto height = [&](int c, int r) { return c == 300 && r == 40 ? 100000.0 / 3 : 5000 + hills(c, r) / 3; };
  EXPECT_GT(expect_equal_sides(test::make_exact_terrain(385, 65, height), 64, 0.1).stretches, 0);
}

/// The line's inner vertices in a band.
std::int64_t inner_vertices(RightTriangleMesh& start, const Side& side) {
  std::array<bool, 2> open_ends{};
  const StartMesh band = start.band(side, open_ends);
  return std::ranges::count_if(band.vertices, [&](const LatticeVertex& v) {
    return side.across(v) == 0 && side.along(v) > 0 && side.along(v) < side.cells;
  });
}

TEST(BorderRibbon, APlaneNeedsNoVerticesInside) {
  const Terrain terrain = test::make_terrain(65, 65, [](int c, int r) { return 0.5 * c + 3 * r; });
  SurfaceView view(*terrain.surface);
  BorderRibbon ribbon;
  for (const Side& side :
       {Side{16, 32, 16, false}, Side{32, 16, 16, true}, Side{0, 0, 64, false}, Side{64, 0, 64, true}}) {
    const LevelGrid level{side.cells, 1, {0.25}};
    // The tile that has the side on its north or its east.
    RightTriangleMesh start(view, level, side.southward ? side.column - side.cells : side.column, side.row);
    EXPECT_EQ(inner_vertices(start, side), 15) << "a vertex at each square's corner, and no others on a plane";
    EXPECT_EQ(ribbon.settle(view, start, side, level).steps.size(), 15U);
  }
}

TEST(BorderRibbon, APlaneThatEndsBesideTheSideNeedsNoVerticesInside) {
  // Where the DEM ends the start mesh is as fine as the cells, and on the other side its triangles grow from there.
  for (const int rows : {130, 131, 134}) {
    const Terrain terrain = test::make_terrain(129, rows, [](int c, int r) { return 0.5 * c + 3 * r; });
    SurfaceView view(*terrain.surface);
    const Side side{0, 128, 128, false};
    const LevelGrid level{side.cells, 1, {0.25}};
    RightTriangleMesh start(view, level, 0, 0);
    const std::int64_t inner = inner_vertices(start, side);
    EXPECT_GT(inner, 15);
    const RibbonPlan plan = BorderRibbon().settle(view, start, side, level);
    EXPECT_GT(plan.flips.size(), 0U);
    EXPECT_EQ(static_cast<std::int64_t>(plan.steps.size()), inner) << rows << " rows";
  }
}

TEST(BorderRibbon, BothNeighboursSettleTheSameSteps) {
  std::size_t steps = 0;
  std::size_t flips = 0;
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const Terrain terrain =
        test::make_terrain(300, 280, test::rough_hills(30, 1, seed % 2 == 0 ? 0 : 0.002 * seed, seed));
    const LevelGrid level{std::int64_t{16} << seed % 4, 0.5 * std::pow(2.0, seed), {0.125 * std::pow(2.0, seed)}};
    SurfaceView view(*terrain.surface);
    BorderRibbon ribbon;
    const std::int64_t n = level.cells;
    for (std::int64_t k = 0; k < 2; ++k) {
      RightTriangleMesh here(view, level, k * n, n);
      RightTriangleMesh east(view, level, (k + 1) * n, n);
      RightTriangleMesh south(view, level, k * n, 2 * n);
      const Side eastern{(k + 1) * n, n, n, true};
      const Side southern{k * n, 2 * n, n, false};
      const auto settled = ribbon.settle(view, here, eastern, level);
      EXPECT_EQ(settled, ribbon.settle(view, east, eastern, level));
      steps += settled.steps.size();
      flips += settled.flips.size();
      EXPECT_EQ(ribbon.settle(view, here, southern, level), ribbon.settle(view, south, southern, level));
    }
  }
  EXPECT_GT(steps, 50U);
  EXPECT_GT(flips, 50U);
}

TEST(BorderRibbon, DoesNotDependOnWhatItSettledBefore) {
  const Terrain terrain = test::make_terrain(129, 129, test::rough_hills(30, 1, 0.02));
  const LevelGrid level{16, 1, {0.25}};
  SurfaceView view(*terrain.surface);
  BorderRibbon used;
  for (std::int64_t k = 0; k < 8; ++k) {
    const Side side{16 * k, 64, 16, k % 2 == 0};
    RightTriangleMesh start(view, level, side.column, side.row);
    const auto again = used.settle(view, start, side, level);
    const auto fresh = BorderRibbon().settle(view, start, side, level);
    EXPECT_EQ(again, fresh);
  }
}

}  // namespace
}  // namespace tintree::simplify
