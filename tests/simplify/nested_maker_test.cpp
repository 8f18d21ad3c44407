/// Trees of method `nested`, checked by brute force: the stored tiles, and every mesh that is nested in them.

#include "simplify/nested_maker.h"

#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "codec/nested_mesh.h"
#include "codec/nested_tile.h"
#include "tests/simplify/support.h"
#include "tests/simplify/whole_tree.h"
#include "tests/support/adversarial_terrain.h"

namespace tintree::test {
namespace {

using codec::NestedTile;
using codec::TileMesh;

class NestedMakerTest : public testing::TestWithParam<AdversarialTerrain> {};

TEST_P(NestedMakerTest, KeepsItsPromises) {
  const AdversarialTerrain& shape = GetParam();
  SCOPED_TRACE(shape.about);
  const Terrain terrain = open_terrain(shape);
  if (!terrain.surface->has_surface()) return;
  const cache::RasterInfo& info = terrain.surface->blocks().source().info();
  const double spacing_m = std::sqrt(info.dx_m * info.dy_m);
  expect_sound_build(terrain, shape.columns > 100 ? 32 : 16, spacing_m / 2, "nested");
}

INSTANTIATE_TEST_SUITE_P(Terrains, NestedMakerTest, testing::ValuesIn(adversarial_terrains()),
                         [](const auto& shape) { return shape.param.name; });

/// Level `level` of a tile as a mesh of its own.
TileMesh level_mesh(const NestedTile& tile, int level) {
  TileMesh out;
  out.xy_shift = tile.xy_shift;
  out.z_offset = tile.z_offset;
  const auto i = static_cast<std::size_t>(level);
  out.vertices.assign(tile.vertices.begin(), tile.vertices.begin() + tile.level_vertices[i]);
  std::size_t begin = 0;
  const std::vector<std::uint32_t>& fans = tile.fans[i];
  for (std::size_t k = 0; k < fans.size(); ++k) {
    if (fans[k] == NestedFans::kRestart) {
      begin = k + 1;
    } else if (k >= begin + 2) {
      out.triangles.push_back({fans[begin], fans[k - 1], fans[k]});
    }
  }
  return out;
}

/// Places on the sides of a tile, and heights there, from the DEM's first sample.
std::set<std::array<double, 3>> border(const codec::TreeLayout& layout, const codec::TileId& id, const TileMesh& mesh) {
  const codec::GridFrame frame(layout, id, mesh);
  const codec::CellRect cells = layout.cells(id);
  std::set<std::array<double, 3>> out;
  for (const codec::GridVertex& v : mesh.vertices) {
    const double c = frame.column(v.x);
    const double r = frame.row(v.y);
    if (c == static_cast<double>(cells.column0) || c == static_cast<double>(cells.column1) ||
        r == static_cast<double>(cells.row0) || r == static_cast<double>(cells.row1)) {
      out.insert({c, r, frame.height_m(v.z)});
    }
  }
  return out;
}

NestedTile nested_tile(simplify::NestedMaker& maker, const codec::TileId& id) {
  const auto mesh = maker.make(id);
  EXPECT_TRUE(mesh.has_value()) << mesh.error().text();
  const auto bytes = codec::NestedMesh().encode(*mesh);
  EXPECT_TRUE(bytes.has_value()) << bytes.error().text();
  return *codec::decode_nested(*bytes);
}

TEST(NestedMaker, EveryNestedMeshKeepsItsTolerance) {
  // Spacing 1 m: the tolerances lie below the vertices' distance, so that nothing is left unrefined.
  for (const double holes : {0.0, 0.002}) {
    const Terrain terrain = make_terrain(129, 129, rough_hills(6, 0.05, holes, 3));
    codec::TreeLayout layout = make_layout(terrain, 64, 0.0005);
    simplify::NestedMaker maker(*terrain.surface, layout);
    for (const codec::TileId& id : {codec::TileId{0, 0, 0}, {1, 1, 0}, {1, 0, 1}}) {
      const NestedTile tile = nested_tile(maker, id);
      ASSERT_EQ(tile.levels, 9);
      const double bound_m = layout.bound_m(id.level);
      for (int level = 0; level < tile.levels; ++level) {
        SCOPED_TRACE("tile " + id.text() + " level " + std::to_string(level));
        const TileMesh mesh = level_mesh(tile, level);
        const double tolerance_m = std::ldexp(bound_m, tile.levels - 1 - level);
        const Overlay found = overlay(terrain.grid, layout, id, mesh);
        EXPECT_LE(found.coverage_error, 1e-9);
        EXPECT_LE(found.max_m, tolerance_m * (1 + 1e-9));
        if (level == 0) continue;
        EXPECT_GE(tile.level_vertices[static_cast<std::size_t>(level)],
                  tile.level_vertices[static_cast<std::size_t>(level) - 1]);
      }
      EXPECT_LT(tile.level_vertices.front(), tile.level_vertices.back());
    }
  }
}

TEST(NestedMaker, NeighboursShareTheirBordersOnEveryLevel) {
  const Terrain terrain = make_terrain(129, 65, rough_hills(20, 1, 0, 7));
  const codec::TreeLayout layout = make_layout(terrain, 64, 0.5);
  simplify::NestedMaker maker(*terrain.surface, layout);
  const NestedTile west = nested_tile(maker, {1, 0, 0});
  const NestedTile east = nested_tile(maker, {1, 1, 0});
  for (int level = 0; level < west.levels; ++level) {
    const auto on_side = [](std::set<std::array<double, 3>> places) {
      std::erase_if(places, [](const auto& p) { return p[0] != 64; });
      return places;
    };
    const auto a = on_side(border(layout, {1, 0, 0}, level_mesh(west, level)));
    EXPECT_GE(a.size(), level + 1 < west.levels ? 2U : 17U);
    EXPECT_EQ(a, on_side(border(layout, {1, 1, 0}, level_mesh(east, level)))) << level;
  }
}

TEST(NestedMaker, CoarseMeshesStopAtTheDistanceOfTheirTolerance) {
  // A cliff of 1000 m: only the tile's own mesh may follow it from sample to sample.
  const Terrain terrain = make_terrain(65, 65, [](int c, int r) { return c + r / 3 < 40 ? 0.0 : 1000.0; });
  const codec::TreeLayout layout = make_layout(terrain, 64, 0.5);
  simplify::NestedMaker maker(*terrain.surface, layout);
  const NestedTile tile = nested_tile(maker, {0, 0, 0});
  for (int level = 0; level < tile.levels; ++level) {
    const double tolerance_m = std::ldexp(layout.bound_m(0), tile.levels - 1 - level);
    const TileMesh mesh = level_mesh(tile, level);
    double closest_m = 1e9;
    for (const codec::Triangle& t : mesh.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const codec::GridVertex& a = mesh.vertices[t[k]];
        const codec::GridVertex& b = mesh.vertices[t[(k + 1) % 3]];
        closest_m = std::min(closest_m, std::ldexp(std::hypot(b.x - a.x, b.y - a.y), tile.xy_shift));
      }
    }
    // The first four triangles are there whatever the tolerance.
    EXPECT_GE(closest_m, level + 1 < tile.levels ? std::min(tolerance_m * 0.999, 45.0) : 0) << level;
  }
  EXPECT_LE(overlay(terrain.grid, layout, {0, 0, 0}, level_mesh(tile, tile.levels - 1)).max_m, layout.bound_m(0));
}

}  // namespace
}  // namespace tintree::test
