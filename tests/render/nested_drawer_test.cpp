/// Tiles of method `nested` under OSMesa: heights as the pure functions say, no gap, no jump, nothing sent twice.

#include "render/nested_drawer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>

#include <gtest/gtest.h>

#include "codec/nested_mesh.h"
#include "tests/render/osmesa_test.h"

namespace tintree::render {
namespace {

using codec::NestedTile;
using codec::RightTriangles;
using codec::TileId;

constexpr double kSpacing_m = 5;
constexpr double kStep_m = 1.0 / 64;

codec::TreeLayout layout() {
  codec::TreeLayout out;
  out.columns = out.rows = 257;
  out.tile_cells = 64;
  out.leaf_level = 2;
  out.dx_m = out.dy_m = kSpacing_m;
  out.leaf_error_m = 0.1;
  out.z_step_m.assign(3, kStep_m);
  return out;
}

double ground_m(double x, double y) {
  return 50 * std::sin(x / 90) * std::cos(y / 70) + 14 * std::sin(x / 19 + y / 23);
}

/// A tile of 65 x 65 vertices, that come level by level as the triangles are halved.
NestedTile make_tile(const TileId& id) {
  const codec::TreeLayout l = layout();
  const std::int64_t step = l.cells_across(id.level) / 64;
  RightTriangles points(6);
  const auto add = [&](std::int32_t x, std::int32_t y, int level) {
    const double east = static_cast<double>((id.x * 64 + x) * step) * kSpacing_m;
    const double south = static_cast<double>((id.y * 64 + y) * step) * kSpacing_m;
    points.add({x, y, static_cast<std::int32_t>(std::lround((ground_m(east, -south) + 100) / kStep_m)),
                static_cast<std::uint8_t>(level), false});
  };
  for (std::int32_t i = 0; i < RightTriangles::kBasePoints; ++i) {
    const auto [x, y] = points.base_place(i);
    add(x, y, 0);
  }
  for (std::int32_t y = 0; y <= 64; ++y) {
    for (std::int32_t x = 0; x <= 64; ++x) {
      if (points.find(x, y) >= 0) continue;
      const int unit = (x | y) & -(x | y);
      int depth = (x & y & unit) != 0 ? 0 : 1;
      for (int u = unit; u < 32; u *= 2) depth += 2;
      add(x, y, std::min(8, depth * 3 / 4));
    }
  }
  codec::TileMesh mesh = codec::finest_mesh(points);
  mesh.z_offset = -6400;
  mesh.xy_shift = l.leaf_level - id.level;
  return *codec::decode_nested(*codec::NestedMesh().encode(mesh));
}

class NestedDrawerTest : public OsMesaTest {
 protected:
  void SetUp() override {
    const std::size_t largest = NestedDrawer::chunk_bytes(tile({2, 0, 0}));
    auto made = NestedDrawer::create(gl_, layout_, std::size_t{32} << 20, largest);
    ASSERT_TRUE(made) << made.error().text();
    drawer_.emplace(std::move(*made));
  }

  const NestedTile& tile(const TileId& id) {
    const auto [at, added] = tiles_.try_emplace(id.key());
    if (added) at->second = make_tile(id);
    return at->second;
  }

  std::vector<NestedView> views(const std::vector<TileId>& ids) {
    std::vector<NestedView> out;
    for (const TileId& id : ids) out.push_back({id, &tile(id)});
    return out;
  }
  static std::vector<TileId> leaves() {
    std::vector<TileId> out;
    for (std::uint32_t y = 0; y < 4; ++y) {
      for (std::uint32_t x = 0; x < 4; ++x) out.push_back({2, x, y});
    }
    return out;
  }

  Picture picture(const Camera& camera, const std::vector<NestedView>& tiles, const NestedStyle& style) {
    const auto target = OffscreenTarget::create(gl_, camera.width_px, camera.height_px, 1);
    EXPECT_TRUE(target);
    stats_ = drawer_->draw(*target, camera, tiles, style);
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    return target->read_picture();
  }

  static Camera camera(const glm::dvec3& eye, const glm::dvec3& target) {
    Camera c;
    c.eye = eye;
    c.target = target;
    c.width_px = 321;
    c.height_px = 241;
    c.fov_y_rad = 0.6;
    return c;
  }

  static int count_magenta(const Picture& p) {
    int count = 0;
    for (int y = 0; y < p.height_px; ++y) {
      for (int x = 0; x < p.width_px; ++x) {
        const auto c = p.at(x, y);
        count += c[0] == 255 && c[1] == 0 && c[2] == 255 ? 1 : 0;
      }
    }
    return count;
  }

  const codec::TreeLayout layout_ = layout();
  std::map<std::int64_t, NestedTile> tiles_;
  std::optional<NestedDrawer> drawer_;
  NestedStats stats_;
};

TEST_F(NestedDrawerTest, HeightsAreThoseOfThePureFunctions) {
  const TileId id{2, 1, 1};
  const NestedTile& t = tile(id);
  codec::TileMesh address;
  address.xy_shift = t.xy_shift;
  address.z_offset = t.z_offset;
  const codec::GridFrame frame(layout_, id, address);
  const auto [low, high] = std::ranges::minmax(t.vertices, {}, &codec::GridVertex::z);
  int between = 0;
  for (std::size_t v = 0; v < t.vertices.size(); v += 97) {
    const codec::GridVertex& p = t.vertices[v];
    if (p.x % 64 == 0 || p.y % 64 == 0) continue;
    const auto at = frame.world(p);
    for (const double up : {60.0, 250.0, 900.0, 4000.0}) {
      Camera down = camera({at[0], at[1], at[2] + up}, {at[0], at[1], at[2]});
      std::array<glm::dvec3, 8> corners{};
      for (std::size_t k = 0; k < 8; ++k) {
        const auto w = frame.world({(k & 1) != 0 ? 64 : 0, (k & 2) != 0 ? 64 : 0, (k & 4) != 0 ? high.z : low.z});
        corners[k] = {w[0], w[1], w[2]};
      }
      const CornerLevels levels = corner_levels(down, corners, layout_.bound_m(2), t.levels, 5);
      const float level = level_at(levels, {static_cast<float>(p.x) / 64, static_cast<float>(p.y) / 64,
                                            static_cast<float>(p.z - low.z) / static_cast<float>(high.z - low.z)});
      const auto weights = morph_weights(level, t.levels);
      double z = 0;
      for (int i = 0; i < t.levels; ++i)
        z += static_cast<double>(weights[static_cast<std::size_t>(i)]) * t.height(v, i);
      // A vertex that the mesh lacks is wherever the mesh is.
      if (v >= t.level_vertices[static_cast<std::size_t>(mesh_level(levels, t.levels))]) continue;
      const auto target = OffscreenTarget::create(gl_, 321, 241, 1);
      ASSERT_TRUE(target);
      drawer_->draw(*target, down, views({id}), {.pixel_error = 5, .morph = true});
      const double depth = 0.1 / static_cast<double>(target->read_depth(160, 120));
      EXPECT_NEAR(depth, at[2] + up - (z + static_cast<double>(t.z_offset)) * kStep_m, 0.02 + 1e-4 * up)
          << "vertex " << v << " from " << up << " m, level " << level;
      between += std::abs(z - p.z) * kStep_m > 0.2 ? 1 : 0;
    }
  }
  EXPECT_GT(between, 3) << "no vertex was moved";
}

TEST_F(NestedDrawerTest, HasNoGapBetweenTiles) {
  std::vector<TileId> mixed{{1, 0, 0}, {1, 1, 1}};
  for (const auto& [x, y] : {std::pair{2U, 0U}, {3U, 0U}, {2U, 1U}, {3U, 1U}, {0U, 2U}, {1U, 2U}, {0U, 3U}, {1U, 3U}})
    mixed.push_back({2, x, y});
  int open = 0;
  for (const auto& ids : {leaves(), mixed}) {
    for (int i = 0; i < 10; ++i) {
      const glm::dvec3 eye(480 + 23 * i, -760 + 17 * i, 260 - 12 * i);
      const Camera c = camera(eye, eye + glm::dvec3(120, 110, -190));
      for (const bool morph : {false, true}) {
        NestedStyle style{.pixel_error = 4, .morph = morph, .background = {1, 0, 1}};
        EXPECT_EQ(count_magenta(picture(c, views(ids), style)), 0) << "camera " << i << ", morph " << morph;
        style.stitch = false;
        open += count_magenta(picture(c, views(ids), style));
      }
    }
  }
  EXPECT_GT(open, 0) << "there was nothing to stitch";
}

/// How much consecutive pictures of a slow flight differ: the mean over pixels, of each pair.
class NestedFlight : public NestedDrawerTest {
 protected:
  std::vector<double> changes(const NestedStyle& style) {
    std::vector<double> out;
    std::optional<Picture> before;
    for (int i = 0; i < 60; ++i) {
      const glm::dvec3 eye(300 + 1.0 * i, -980 + 1.0 * i, 240);
      Picture now = picture(camera(eye, eye + glm::dvec3(200, 200, -110)), views(leaves()), style);
      triangles_.push_back(stats_.triangles);
      if (before) {
        double sum = 0;
        for (std::size_t k = 0; k < now.rgb.size(); ++k) sum += std::abs(int{now.rgb[k]} - int{before->rgb[k]});
        out.push_back(sum / static_cast<double>(now.rgb.size()));
      }
      before = std::move(now);
    }
    return out;
  }
  /// The largest change against the usual one.
  static double jump(std::vector<double> changes) {
    std::ranges::sort(changes);
    return changes.back() / changes[changes.size() / 2];
  }
  std::vector<std::uint64_t> triangles_;
};

TEST_F(NestedFlight, MorphsWithoutAJump) {
  const double morphing = jump(changes({.pixel_error = 5, .morph = true}));
  EXPECT_NE(std::ranges::min(triangles_), std::ranges::max(triangles_)) << "levels never changed";
  const double jumping = jump(changes({.pixel_error = 5, .morph = false}));
  EXPECT_LT(morphing, 1.3);
  EXPECT_GT(jumping, 1.5 * morphing) << "the measure sees no jump";
}

TEST_F(NestedDrawerTest, SendsEachVertexOnce) {
  std::size_t sent = 0;
  for (int i = 0; i < 20; ++i) {
    const glm::dvec3 eye(640, -640, 4000 / (1.0 + i));
    picture(camera(eye, {640, -639, 0}), views(leaves()), {});
    sent += stats_.vertex_bytes;
    EXPECT_EQ(stats_.without_room, 0U);
  }
  picture(camera({640, -640, 200}, {640, -639, 0}), views(leaves()), {});
  picture(camera({640, -640, 200}, {640, -639, 0}), views(leaves()), {});
  EXPECT_EQ(stats_.vertex_bytes + stats_.index_bytes, 0U);
  EXPECT_LE(sent, 16U * 65 * 65 * sizeof(NestedVertex));
  EXPECT_GT(sent, 16U * 65 * 65 * sizeof(NestedVertex) / 8);
}

TEST_F(NestedDrawerTest, DrawsWhatFits) {
  const std::size_t largest = NestedDrawer::chunk_bytes(tile({2, 0, 0}));
  auto small = NestedDrawer::create(gl_, layout_, 1, largest);
  ASSERT_TRUE(small);
  const auto target = OffscreenTarget::create(gl_, 321, 241, 1);
  const NestedStats stats =
      small->draw(*target, camera({640, -640, 900}, {640, -639, 0}), views(leaves()), {.pixel_error = 1});
  EXPECT_EQ(stats.without_room, 15U) << "one chunk is large enough";
  EXPECT_GT(stats.triangles, 0U);
}

TEST(Stitch, FillsBetweenTwoLines) {
  const std::vector<BorderVertex> one{{0, 10}, {4, 11}, {8, 12}};
  const std::vector<BorderVertex> other{{0, 20}, {8, 21}};
  const auto triangles = stitch(one, other);
  // As many as both have edges, each with a corner on either line.
  EXPECT_EQ(triangles.size(), 3U);
  std::map<std::pair<bool, std::uint32_t>, int> uses;
  for (const auto& t : triangles) {
    EXPECT_FALSE(t[0].other);
    EXPECT_TRUE(t[1].other);
    for (const StitchCorner& c : t) ++uses[{c.other, c.vertex}];
  }
  EXPECT_EQ(uses.size(), 5U);
}

TEST(Stitch, OverlapsItsNeighbours) {
  std::vector<BorderVertex> other;
  for (std::uint32_t i = 0; i <= 16; ++i) other.push_back({4 * i, i});
  const std::vector<BorderVertex> one{{16, 100}, {22, 101}, {32, 102}};
  std::uint32_t first = 99;
  std::uint32_t last = 0;
  for (const auto& t : stitch(one, other)) {
    for (const StitchCorner& c : t) {
      if (!c.other) continue;
      first = std::min(first, c.vertex);
      last = std::max(last, c.vertex);
    }
  }
  EXPECT_EQ(first, 3U);
  EXPECT_EQ(last, 9U);
}

TEST(Stitch, NeedsTwoLines) {
  EXPECT_TRUE(stitch({}, {}).empty());
  const std::vector<BorderVertex> one{{0, 1}};
  EXPECT_TRUE(stitch(one, one).empty());
}

}  // namespace
}  // namespace tintree::render
