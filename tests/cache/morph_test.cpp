#include "cache/morph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "tests/render/analytic_tree.h"

namespace tintree::cache {
namespace {

using Point = std::array<double, 4>;  // Column, row, metres, metres of the goal.

/// Heights at a place, by looking at every triangle.
template <typename Indices>
std::optional<std::array<double, 2>> heights_m(const std::vector<Point>& points, const Indices& indices, double column,
                                               double row) {
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    const std::array<Point, 3> p{points[indices[i]], points[indices[i + 1]], points[indices[i + 2]]};
    const auto area = [&](std::size_t a, std::size_t b) {
      return (p[a][0] - column) * (p[b][1] - row) - (p[b][0] - column) * (p[a][1] - row);
    };
    const std::array<double, 3> w{area(1, 2), area(2, 0), area(0, 1)};
    const double all = w[0] + w[1] + w[2];
    if (std::abs(all) < 1e-9 || std::ranges::any_of(w, [&](double v) { return v / all < -1e-6; })) continue;
    std::array<double, 2> out{};
    for (std::size_t z = 0; z < 2; ++z) out[z] = (w[0] * p[0][2 + z] + w[1] * p[1][2 + z] + w[2] * p[2][2 + z]) / all;
    return out;
  }
  return std::nullopt;
}

std::vector<Point> points_of(const DrawableTile& tile) {
  std::vector<Point> out;
  for (const DrawVertex& v : tile.vertices) {
    const double z = tile.frame.height_m(v.z());
    out.push_back({tile.frame.column(v.x()), tile.frame.row(v.y()), z, z});
  }
  return out;
}

std::vector<Point> points_of(const DrawableTile& tile, const MorphMesh& morph) {
  const auto height = [&](float z) {
    return (static_cast<double>(z) + static_cast<double>(tile.frame.z_offset)) * tile.frame.z_step_m;
  };
  const double step = std::ldexp(1.0, tile.frame.xy_shift);
  std::vector<Point> out;
  for (const MorphVertex& v : morph.vertices) {
    out.push_back({static_cast<double>(tile.frame.column0) + static_cast<double>(v.x) * step,
                   static_cast<double>(tile.frame.row0) + static_cast<double>(v.y) * step, height(v.z),
                   height(v.goal_z)});
  }
  return out;
}

/// A tile whose triangles share nothing with its parent's: its inner samples are moved aside.
class MorphTest : public testing::Test {
 protected:
  MorphTest() {
    tree_.columns = 120;
    tree_.rows = 101;
    tree_.tile_cells = 32;
  }

  DrawableTile tile(const codec::TileId& id, bool aside = true) const {
    codec::TileMesh mesh = tree_.mesh(id);
    const codec::TreeLayout layout = tree_.layout();
    const codec::CellRect c = layout.cells(id);
    mesh.xy_shift = -3;
    const auto step = static_cast<std::int32_t>(layout.cells_across(id.level) / tree_.tile_cells);
    std::mt19937 random(static_cast<unsigned>(id.key()));
    for (codec::GridVertex& v : mesh.vertices) {
      const bool side = v.x == 0 || v.y == 0 || v.x == c.column1 - c.column0 || v.y == c.row1 - c.row0;
      v.x *= 8;
      v.y *= 8;
      if (side || !aside) continue;
      v.x += static_cast<std::int32_t>(random() % 3) * step - step;
      v.y += static_cast<std::int32_t>(random() % 3) * step - step;
    }
    EXPECT_TRUE(codec::validate(mesh, layout.cells_across(id.level)));
    return make_drawable(layout, id, mesh);
  }

  test::AnalyticTree tree_;
};

TEST_F(MorphTest, HasBothSurfacesAtEveryPlace) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> in(0, 1);
  for (const codec::TileId& id : tree_.tiles()) {
    if (id.level == 0) continue;
    for (const bool aside : {true, false}) {
      const DrawableTile own = tile(id, aside);
      const DrawableTile parent = tile(tree_.layout().parent(id), aside);
      const auto morph = make_morph(own, parent);
      ASSERT_TRUE(morph) << id.text();
      const auto surface = std::span(morph->indices).first(3 * std::size_t{morph->surface_triangles});
      const auto between = points_of(own, *morph), own_points = points_of(own), goal_points = points_of(parent);
      const auto own_surface =
          std::span<const std::uint16_t>(own.indices).first(3 * std::size_t{own.surface_triangles});
      const auto goal_surface =
          std::span<const std::uint16_t>(parent.indices).first(3 * std::size_t{parent.surface_triangles});
      const codec::CellRect c = tree_.layout().cells(id);
      for (int i = 0; i < 12; ++i) {
        const double column = std::lerp(static_cast<double>(c.column0), static_cast<double>(c.column1), in(random));
        const double row = std::lerp(static_cast<double>(c.row0), static_cast<double>(c.row1), in(random));
        const auto both = heights_m(between, surface, column, row);
        ASSERT_TRUE(both) << id.text();
        EXPECT_NEAR((*both)[0], (*heights_m(own_points, own_surface, column, row))[0], 0.01) << id.text();
        EXPECT_NEAR((*both)[1], (*heights_m(goal_points, goal_surface, column, row))[0], 0.01) << id.text();
      }
    }
  }
}

// Every edge within the square belongs to two triangles, so that no gap opens on the way; those on its sides that the
// raster goes on behind have a skirt.
TEST_F(MorphTest, IsWatertight) {
  const codec::TileId id{2, 1, 1};
  const DrawableTile own = tile(id);
  const auto morph = make_morph(own, tile(tree_.layout().parent(id)));
  ASSERT_TRUE(morph);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (std::size_t i = 0; i < 3 * std::size_t{morph->surface_triangles}; ++i) {
    const std::uint32_t a = morph->indices[i];
    const std::uint32_t b = morph->indices[i % 3 == 2 ? i - 2 : i + 1];
    ++edges[{std::min(a, b), std::max(a, b)}];
  }
  int sides = 0;
  for (const auto& [edge, times] : edges) {
    const MorphVertex& a = morph->vertices[edge.first];
    const MorphVertex& b = morph->vertices[edge.second];
    const auto on = [](float p, float q, float side) { return p == side && q == side; };
    const bool side = on(a.x, b.x, 0) || on(a.y, b.y, 0) || on(a.x, b.x, 256) || on(a.y, b.y, 256);
    sides += side ? 1 : 0;
    EXPECT_EQ(times, side ? 1 : 2) << a.x << " " << a.y << " " << b.x << " " << b.y;
  }
  EXPECT_GE(sides, 4 * 32);
  EXPECT_EQ(morph->indices.size() - 3 * std::size_t{morph->surface_triangles}, 6 * static_cast<std::size_t>(sides));
}

TEST_F(MorphTest, NeighboursAgreeOnTheirSide) {
  const codec::TileId west{2, 1, 1}, east{2, 2, 1};  // Of different parents.
  const auto side = [&](const codec::TileId& id, double column) {
    const DrawableTile own = tile(id);
    const auto morph = make_morph(own, tile(tree_.layout().parent(id)));
    std::set<std::array<double, 3>> out;
    for (const Point& p : points_of(own, *morph)) {
      if (p[0] == column) out.insert({p[1], p[2], p[3]});
    }
    return out;
  };
  EXPECT_EQ(side(west, 64), side(east, 64));
  EXPECT_GE(side(west, 64).size(), 33U);
}

TEST_F(MorphTest, HolesDoNotMorph) {
  const codec::TileId id{2, 1, 1};
  const DrawableTile own = tile(id, false);
  const DrawableTile parent = tile(tree_.layout().parent(id), false);
  tree_.hole = [](double x, double y) { return std::hypot(x - 450, y + 450) < 40; };
  EXPECT_FALSE(make_morph(tile(id, false), parent));
  EXPECT_FALSE(make_morph(own, tile(tree_.layout().parent(id), false)));
  EXPECT_TRUE(make_morph(own, parent));
}

}  // namespace
}  // namespace tintree::cache
