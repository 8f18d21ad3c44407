/// Nested levels made ready to be drawn: the coarser ones are the ancestors' meshes, at every place.

#include "cache/nested_shape.h"

#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "cache/drawable_tile.h"
#include "tests/support/nested_tree.h"

namespace tintree::cache {
namespace {

using test::NestedTree;

struct Made {
  codec::TileMesh mesh;
  DrawableTile drawable;
  NestedShape shape;
};

Made make(const codec::TileId& id, const NestedShape* parent, codec::TileMesh mesh) {
  Made out{std::move(mesh), {}, {}};
  out.drawable = make_drawable(NestedTree::layout(), id, out.mesh);
  EXPECT_TRUE(can_have_nested_shape(NestedTree::layout(), id, out.mesh));
  out.shape =
      make_nested_shape(NestedTree::layout(), id, out.mesh, out.drawable, NestedTree::error_m(id.level), 0, parent);
  return out;
}

Made make(const codec::TileId& id, const NestedShape* parent) { return make(id, parent, NestedTree::mesh(id)); }

/// Height of a triangle over a place, if it lies there.
std::optional<double> height_in(const std::array<std::array<double, 3>, 3>& t, double x, double y) {
  const auto side = [&](const auto& a, const auto& b) {
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
  };
  const double u = side(t[1], t[2]);
  const double v = side(t[2], t[0]);
  const double w = side(t[0], t[1]);
  constexpr double kRim = -1e-6;
  if (u < kRim || v < kRim || w < kRim) return std::nullopt;
  return (u * t[0][2] + v * t[1][2] + w * t[2][2]) / (u + v + w);
}

/// Of a level's fans, at a place of the world; NaN where there is no triangle.
double level_height_m(const NestedShape& shape, int level, double x, double y) {
  const auto corner = [&](std::uint32_t v) -> std::array<double, 3> {
    const NestedVertex& p = shape.vertices[v];
    EXPECT_LT(v, shape.level_vertices(level));
    const auto k = static_cast<std::size_t>(level);
    const double rise = level < 8 ? p.rises[k] * static_cast<double>(shape.units[k]) : 0;
    auto at = shape.frame.world({p.x(), p.y(), p.z()});
    at[2] += rise * shape.frame.z_step_m;
    return at;
  };
  const auto& fans = shape.level_fans(level);
  std::size_t begin = 0;
  for (std::size_t i = 0; i < fans.size(); ++i) {
    if (fans[i] == codec::NestedFans::kRestart) begin = i + 1;
    if (i < begin + 2) continue;
    const auto height = height_in({corner(fans[begin]), corner(fans[i - 1]), corner(fans[i])}, x, y);
    if (height) return *height;
  }
  return std::nan("");
}

double mesh_height_m(const Made& tile, double x, double y) {
  const codec::GridFrame frame(NestedTree::layout(), tile.drawable.id, tile.mesh);
  for (const codec::Triangle& t : tile.mesh.triangles) {
    const auto height = height_in({frame.world(tile.mesh.vertices[t[0]]), frame.world(tile.mesh.vertices[t[1]]),
                                   frame.world(tile.mesh.vertices[t[2]])},
                                  x, y);
    if (height) return *height;
  }
  return std::nan("");
}

TEST(NestedShape, LevelsAreTheMeshesOfTheAncestors) {
  const Made root = make({0, 0, 0}, nullptr);
  std::mt19937 random(7);
  for (std::uint32_t quadrant = 0; quadrant < 4; ++quadrant) {
    const Made middle = make({1, quadrant & 1U, quadrant >> 1}, &root.shape);
    const codec::TileId id{2, 2 * (quadrant & 1U) + (quadrant >> 1), 2 * (quadrant >> 1) + (quadrant & 1U)};
    const Made leaf = make(id, &middle.shape);
    EXPECT_GT(leaf.shape.vertices.size(), leaf.mesh.vertices.size()) << "the parent has no point that it lacks";
    for (int i = 0; i < 40; ++i) {
      const double x = 320 * (id.x + static_cast<double>(random() % 9999 + 1) / 10001);
      const double y = -320 * (id.y + static_cast<double>(random() % 9999 + 1) / 10001);
      EXPECT_NEAR(level_height_m(leaf.shape, 8, x, y), mesh_height_m(leaf, x, y), 1e-3);
      // A rise is rounded to half a 64th of the level's tolerance.
      EXPECT_NEAR(level_height_m(leaf.shape, 7, x, y), mesh_height_m(middle, x, y), 18.0 / 128 + 1e-3);
      EXPECT_NEAR(level_height_m(leaf.shape, 6, x, y), mesh_height_m(root, x, y), 2 * 36.0 / 128 + 1e-3);
      for (int level = 0; level < 8; ++level) {
        EXPECT_NEAR(level_height_m(leaf.shape, level, x, y), NestedTree::ground_m(x, y), std::ldexp(9, 8 - level));
      }
    }
  }
}

TEST(NestedShape, WithoutAParentItsOwnLevelsKeepTheirBounds) {
  const Made leaf = make({2, 1, 2}, nullptr);
  std::mt19937 random(8);
  for (int i = 0; i < 100; ++i) {
    const double x = 320 + static_cast<double>(random() % 3200) / 10;
    const double y = -640 - static_cast<double>(random() % 3200) / 10;
    EXPECT_NEAR(level_height_m(leaf.shape, 8, x, y), mesh_height_m(leaf, x, y), 1e-3);
    for (int level = 0; level < 8; ++level) {
      const double height = level_height_m(leaf.shape, level, x, y);
      EXPECT_NEAR(height, NestedTree::ground_m(x, y), std::ldexp(9, 8 - level));
    }
  }
  EXPECT_LT(leaf.shape.level_vertices(3), leaf.shape.level_vertices(8) / 4);
}

TEST(NestedShape, BordersAreJoinedWhereThereIsSurface) {
  const codec::TileId id{0, 0, 0};
  const auto sea = [](std::int32_t x, std::int32_t y) {
    return (x - 20) * (x - 20) + y * y < 60 || (x > 55 && y > 20 && y < 50);
  };
  const Made tile = make(id, nullptr, NestedTree::mesh(id, sea));
  const NestedShape& shape = tile.shape;
  const double spacing_m = NestedTree::kSpacing_m;
  int open = 0;
  int joined = 0;
  for (std::size_t side = 0; side < 4; ++side) {
    const bool north_south = side % 2 == 0;
    const double line = side < 2 ? 0.01 : 256 - 0.01;  // just inside, in samples
    for (int level = 0; level < NestedShape::kLevels; ++level) {
      const BorderVertex* from = nullptr;
      for (const BorderVertex& to : shape.borders[side]) {
        if (to.vertex >= shape.level_vertices(level)) continue;
        if (from != nullptr) {
          const double middle = static_cast<double>(from->along + to.along) / 4;  // half samples
          const double height = level_height_m(shape, level, (north_south ? line : middle) * spacing_m,
                                               -(north_south ? middle : line) * spacing_m);
          EXPECT_EQ((from->joined_levels >> level & 1) != 0, !std::isnan(height))
              << side << " " << level << " " << middle;
          ++(std::isnan(height) ? open : joined);
        }
        from = &to;
      }
      ASSERT_NE(from, nullptr);
      EXPECT_EQ(from->joined_levels >> level & 1, 0);
    }
  }
  EXPECT_GT(open, 4);
  EXPECT_GT(joined, 100);
}

TEST(NestedShape, RefusesMeshesThatDoNotFillTheTile) {
  const codec::TreeLayout layout = NestedTree::layout();
  codec::TileMesh mesh = NestedTree::mesh({2, 0, 0});
  mesh.xy_shift = 1;
  EXPECT_FALSE(can_have_nested_shape(layout, {2, 0, 0}, mesh));
  mesh = NestedTree::mesh({2, 0, 0});
  mesh.nested_levels.clear();
  EXPECT_FALSE(can_have_nested_shape(layout, {2, 0, 0}, mesh));
}

}  // namespace
}  // namespace tintree::cache
