#include "render/renderer.h"

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "render/frustum.h"
#include "render/screen_error.h"
#include "render/terrain_scene.h"
#include "tests/render/osmesa_test.h"
#include "tests/render/seen.h"
#include "tests/render/analytic_tree.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
const glm::vec3 kMagenta(1, 0, 1);

bool is_magenta(const std::array<std::uint8_t, 3>& c) { return c[0] == 255 && c[1] == 0 && c[2] == 255; }

/// Pictures of an analytic tree under OSMesa, before magenta.
class RendererTest : public OsMesaTest {
 protected:
  void open(const test::AnalyticTree& tree) {
    const std::string path = dir_.path() + "/renderer_test.tintree";
    tree.write(path);
    store_.emplace(std::move(*cache::TileStore::open(path)));
  }

  std::unique_ptr<TerrainScene> scene(double pixel_error = 1) {
    SceneOptions options;
    options.cut.pixel_error = pixel_error;
    auto made = TerrainScene::create(gl_, *store_, options);
    EXPECT_TRUE(made);
    return std::move(*made);
  }

  Picture picture(TerrainScene& scene, const Camera& camera, const LodCut& cut, const Style& style, int samples = 1) {
    const auto target = OffscreenTarget::create(gl_, camera.width_px, camera.height_px, samples);
    EXPECT_TRUE(target);
    scene.draw(*target, camera, cut, style);
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    return target->read_picture();
  }

  static Camera camera(const glm::dvec3& eye, const glm::dvec3& target) {
    return test::camera_at(eye, target, kWidth, kHeight);
  }

  /// A grid turned to the left, and a place in the world turned with it round the origin.
  static codec::GridAxes turned_axes(double angle) {
    return {{std::cos(angle), std::sin(angle)}, {std::sin(angle), -std::cos(angle)}};
  }
  static glm::dvec3 turned(const glm::dvec3& p, double angle) {
    return {p.x * std::cos(angle) - p.y * std::sin(angle), p.x * std::sin(angle) + p.y * std::cos(angle), p.z};
  }

  static Style before_magenta() {
    Style style;
    style.background = kMagenta;
    return style;
  }

  static int count_magenta(const Picture& p) {
    int count = 0;
    for (int y = 0; y < p.height_px; ++y) {
      for (int x = 0; x < p.width_px; ++x) count += is_magenta(p.at(x, y)) ? 1 : 0;
    }
    return count;
  }

  test::TempDir dir_;
  std::optional<cache::TileStore> store_;
};

// Views that lie wholly inside the ground's outline: from straight above, at a slant, and low over it.
TEST_F(RendererTest, NoBackgroundShowsThroughTheGround) {
  open({});
  const auto s = scene();
  for (const Camera& c : {camera({640, -640, 900}, {640, -640.001, 0}), camera({640, -900, 500}, {640, -700, 0}),
                          camera({200, -1100, 400}, {420, -850, 0}), camera({640, -640, 3000}, {641, -640, 0})}) {
    const auto cut = s->settle(c);
    ASSERT_TRUE(cut) << cut.error().text();
    const bool inside = c.eye.z < 2000;
    const Picture p = picture(*s, c, *cut, before_magenta());
    EXPECT_EQ(count_magenta(p) == 0, inside) << c.eye.z;
  }
}

/// A cut in which the leaves of one half stand beside a coarse tile of the other, whatever their errors.
LodCut split_cut(const cache::TileBounds& bounds, const Camera& camera) {
  LodCut cut;
  const Frustum frustum(camera);
  const auto add = [&](const codec::TileId& id) {
    const auto node = static_cast<std::uint32_t>(bounds.find(id));
    const cache::Box box = bounds.box(bounds.nodes()[node]);
    cut.draws.push_back({0, node, 0, frustum.nearest_depth_m(box), frustum.farthest_depth_m(box), false});
    const auto error = static_cast<double>(bounds.nodes()[node].lod_error_m);
    cut.max_error_px = std::max(cut.max_error_px, ScreenError(camera).bound_px(box, error).value_or(0));
    cut.farthest_m = std::max(cut.farthest_m, cut.draws.back().farthest_m);
  };
  for (std::uint32_t y = 0; y < 2; ++y) {
    for (std::uint32_t x = 0; x < 2; ++x) {
      if ((x + y) % 2 == 0) {
        add({1, x, y});
      } else {
        for (std::uint32_t i = 0; i < 4; ++i) add({2, 2 * x + (i & 1), 2 * y + (i >> 1)});
      }
    }
  }
  return cut;
}

TEST_F(RendererTest, ATurnedTreeLooksTheSameToATurnedEye) {
  const Camera straight = camera({640, -900, 260}, {640, -700, 0});
  std::optional<Picture> first;
  for (const double angle : {0.0, 0.7, -2.9}) {
    test::AnalyticTree tree;
    tree.axes = turned_axes(angle);
    open(tree);
    const auto s = scene(0);
    const Camera c = camera(turned(straight.eye, angle), turned(straight.target, angle));
    const auto cut = s->settle(c);
    ASSERT_TRUE(cut);
    Style style = before_magenta();
    style.sun_azimuth_rad -= angle;
    const Picture p = picture(*s, c, *cut, style);
    EXPECT_EQ(count_magenta(p), 0) << angle;
    if (!first) first = p;
    // Rounding moves outlines by a pixel here and there.
    int different = 0;
    for (std::size_t i = 0; i < p.rgb.size(); ++i) different += std::abs(first->rgb[i] - p.rgb[i]) > 8 ? 1 : 0;
    EXPECT_LT(different, kWidth * kHeight / 100) << angle;
  }
}

class SkirtTest : public RendererTest, public testing::WithParamInterface<double> {};
INSTANTIATE_TEST_SUITE_P(Angles, SkirtTest, testing::Values(0.0, 2.2));

TEST_P(SkirtTest, FillsTheGapsBetweenLevels) {
  test::AnalyticTree tree;
  tree.height_m = [](double x, double y) { return 14 * std::sin(x / 13) * std::cos(y / 11) + 30 * std::sin(x / 300); };
  tree.axes = turned_axes(GetParam());
  open(tree);
  GpuTilePool pool(gl_, {.mesh_bytes = std::size_t{1} << 30});
  for (const codec::TileId& id : tree.tiles()) {
    ASSERT_TRUE(pool.upload({id}, cache::make_drawable(tree.layout(), id, tree.mesh(id))));
  }
  const std::array<const cache::TileBounds*, 1> trees{&store_->bounds()};
  const auto renderer = Renderer::create(gl_);
  const auto target = OffscreenTarget::create(gl_, kWidth, kHeight, 1);
  ASSERT_TRUE(renderer && target);
  int gaps_without = 0;
  for (int view = 0; view < 24; ++view) {
    const double turn = 0.27 * view;
    Camera c = camera({640 + 500 * std::sin(turn), -640 + 500 * std::cos(turn), 420.0}, {640, -640, 0});
    if (view % 3 == 0) c.eye = {640.0 + view, -640.5, 900};
    c.eye = turned(c.eye, GetParam());
    c.target = turned(c.target, GetParam());
    c.fov_y_rad = 0.5;
    const LodCut cut = split_cut(store_->bounds(), c);
    const auto gaps = [&](bool skirts) {
      Style style = before_magenta();
      style.skirts = skirts;
      renderer->draw(*target, c, trees, cut, pool, style);
      return count_magenta(target->read_picture());
    };
    EXPECT_EQ(gaps(true), 0) << view;
    gaps_without += gaps(false);
  }
  EXPECT_GT(gaps_without, 20);
}

TEST_F(RendererTest, TheGroundIsLitFromTheSun) {
  test::AnalyticTree tree;
  tree.height_m = [](double x, double) { return 150 - std::abs(x - 640) * 0.23; };  // A roof along north-south.
  open(tree);
  const auto s = scene();
  const Camera c = camera({640, -640, 1100}, {640, -639.999, 0});
  const auto cut = s->settle(c);
  ASSERT_TRUE(cut);
  Style style = before_magenta();
  const auto brightness = [&](int x) {
    const auto p = picture(*s, c, *cut, style).at(x, kHeight / 2);
    return p[0] + p[1] + p[2];
  };
  style.sun_azimuth_rad = 1.5 * 3.14159265;  // In the west.
  EXPECT_GT(brightness(kWidth / 4), brightness(3 * kWidth / 4) + 60);
  style.sun_azimuth_rad = 0.5 * 3.14159265;
  EXPECT_LT(brightness(kWidth / 4) + 60, brightness(3 * kWidth / 4));
}

TEST_F(RendererTest, FogTakesTheFarGround) {
  open({});
  const auto s = scene();
  const Camera c = camera({640, -1250, 120}, {640, -600, 0});
  const auto cut = s->settle(c);
  ASSERT_TRUE(cut);
  const auto spread = [&](double fog_m, int y) {
    Style style;
    style.fog_m = fog_m;
    const Picture p = picture(*s, c, *cut, style);
    int low = 255, high = 0;
    for (int x = 0; x < kWidth; ++x) low = std::min(low, int{p.at(x, y)[1]}), high = std::max(high, int{p.at(x, y)[1]});
    return high - low;
  };
  EXPECT_GT(spread(0, 110), 20);
  EXPECT_LT(spread(200, 110), 10);
  EXPECT_GT(spread(20000, 110), 10);
}

TEST_F(RendererTest, DepthTellsTheDistance) {
  test::AnalyticTree tree;
  tree.height_m = [](double, double) { return 100; };
  open(tree);
  for (const bool clip_control : {true, false}) {
    GlFunctions gl = gl_;
    if (!clip_control) {
      gl.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
      gl.ClipControl = nullptr;
    }
    const auto s = TerrainScene::create(gl, *store_, {});
    ASSERT_TRUE(s);
    const Camera c = camera({640, -1200, 700}, {640, -700, 100});
    const auto cut = (*s)->settle(c);
    ASSERT_TRUE(cut);
    const auto target = OffscreenTarget::create(gl, kWidth, kHeight, 1);
    ASSERT_TRUE(target);
    (*s)->draw(*target, c, *cut, before_magenta());
    for (const int y : {40, 120, 200}) {
      const auto stored = static_cast<double>(target->read_depth(160, y));
      ASSERT_GT(stored, 0);
      const glm::dvec3 p = c.eye + (*s)->renderer().near_m(*cut) / stored * c.ray(160.5, y + 0.5);
      EXPECT_NEAR(p.z, 100, 0.2) << clip_control << " " << y;
    }
  }
}

TEST_F(RendererTest, ASkyStandsBehindTheGround) {
  open({});
  const auto s = scene();
  const Camera c = camera({640, -1250, 120}, {640, -600, 120});
  const auto cut = s->settle(c);
  ASSERT_TRUE(cut);
  const Picture p = picture(*s, c, *cut, {});
  const auto above = p.at(kWidth / 2, 5);
  EXPECT_GT(above[2], above[0]);
  EXPECT_NE(p.at(kWidth / 2, kHeight - 10), above);
}

// A world far from its origin, with the eye close to the ground: only differences to the eye reach the card.
TEST_F(RendererTest, PicturesDoNotChangeWithThePlaceInTheWorld) {
  const test::AnalyticTree base;
  test::AnalyticTree far = base;
  const double lift = 1000;
  far.height_m = [&](double x, double y) { return base.height_m(x, y) + lift; };
  const Style style = before_magenta();
  const Camera near_camera = camera({640, -900, 160}, {640, -700, 0});
  open(base);
  const auto a = scene();
  const auto cut_a = a->settle(near_camera);
  ASSERT_TRUE(cut_a);
  const Picture first = picture(*a, near_camera, *cut_a, style);
  const Camera far_camera =
      camera(near_camera.eye + glm::dvec3(0, 0, lift), near_camera.target + glm::dvec3(0, 0, lift));
  std::optional<cache::TileStore> other;
  const std::string path = dir_.path() + "/lifted.tintree";
  far.write(path);
  other.emplace(std::move(*cache::TileStore::open(path)));
  const auto b = std::move(*TerrainScene::create(gl_, *other, {}));
  const auto cut_b = b->settle(far_camera);
  ASSERT_TRUE(cut_b);
  const Picture second = picture(*b, far_camera, *cut_b, style);
  int most = 0;
  for (std::size_t i = 0; i < first.rgb.size(); ++i) most = std::max(most, std::abs(first.rgb[i] - second.rgb[i]));
  EXPECT_LE(most, 2);  // Rounding, no more.
}

/// Ridges and valleys as high as they are wide.
double ridges(double x, double y) {
  return 160 * std::sin(x / 210) * std::cos(y / 170) + 60 * std::sin(x / 60 + y / 75);
}

// A slow flight upwards at four pixels. What one step changes is seen by drawing both steps' cuts from one eye: the
// largest jump of any pixel's depth, in pixels at that depth.
TEST_F(RendererTest, MorphsLeaveNothingToPop) {
  test::AnalyticTree tree;
  tree.columns = tree.rows = 257;
  tree.tile_cells = 16;
  tree.height_m = [](double x, double y) { return 20 * std::sin(x / 90) * std::cos(y / 70); };
  open(tree);
  const auto largest_jump = [&](bool morph) {
    SceneOptions options;
    options.cut = {.pixel_error = 4, .morph = morph};
    const auto s = std::move(*TerrainScene::create(gl_, *store_, options));
    const auto target = OffscreenTarget::create(gl_, kWidth, kHeight, 1);
    std::optional<LodCut> before;
    double jump = 0;
    for (int step = 0; step < 40; ++step) {
      const glm::dvec3 eye(1280 + step, -1280, 150 * std::pow(1.04, step));
      const Camera c = camera(eye, eye + glm::dvec3(0.1, 0.2, -1));
      const auto cut = s->settle(c);
      EXPECT_TRUE(cut);
      std::array<std::vector<float>, 2> depths;
      for (std::size_t i = 0; i < 2; ++i) {
        LodCut drawn = i == 0 ? before.value_or(*cut) : *cut;
        drawn.nearest_m = cut->nearest_m;  // One scale of depth.
        drawn.farthest_m = cut->farthest_m;
        s->draw(*target, c, drawn, before_magenta());
        EXPECT_TRUE(c.eye.z > 600 || count_magenta(target->read_picture()) == 0) << step;
        depths[i] = target->read_depths();
      }
      for (std::size_t i = 0; i < depths[0].size(); ++i) {
        if (depths[0][i] <= 0 || depths[1][i] <= 0) continue;
        jump = std::max(jump, std::abs(static_cast<double>(depths[0][i] / depths[1][i]) - 1) * c.focal_px());
      }
      before = *cut;
    }
    return jump;
  };
  const double without = largest_jump(false);
  const double with = largest_jump(true);
  EXPECT_GT(without, 1.5);
  EXPECT_LT(with, 0.25 * without);
}

// Low among ridges, with and without a hole in the ground, level and looking down.
TEST_F(RendererTest, OcclusionChangesNoPixel) {
  std::size_t with = 0, without = 0;
  for (const bool hole : {false, true}) {
    test::AnalyticTree tree;
    tree.columns = tree.rows = 193;
    tree.tile_cells = 16;
    tree.height_m = ridges;
    if (hole) tree.hole = [](double x, double y) { return std::hypot(x - 1000, y + 900) < 120; };
    open(tree);
    const auto s = scene();
    for (int view = 0; view < 16; ++view) {
      const glm::dvec3 ground(400 + 51.0 * view, -500 - 33.0 * view, ridges(400 + 51.0 * view, -500 - 33.0 * view));
      const glm::dvec3 eye = ground + glm::dvec3(0, 0, 12 + 6.0 * (view % 7));
      const Camera c =
          camera(eye, eye + glm::dvec3(std::sin(1.3 * view), std::cos(1.3 * view), 0.1 - 0.15 * (view % 4)));
      std::array<Picture, 2> pictures;
      for (const bool on : {false, true}) {
        s->occlusion() = on ? Occlusion::kAlways : Occlusion::kOff;
        const auto cut = s->settle(c);
        ASSERT_TRUE(cut);
        (on ? with : without) += cut->draws.size();
        pictures[on ? 1 : 0] = picture(*s, c, *cut, {});
      }
      EXPECT_EQ(pictures[0].rgb, pictures[1].rgb) << view << (hole ? " with a hole" : "");
    }
  }
  EXPECT_LT(4 * with, 3 * without);
}

TEST_F(RendererTest, RefusesAFrameLargerThanTheDriverHas) {
  const auto target = OffscreenTarget::create(gl_, 1 << 20, 10, 1);
  ASSERT_FALSE(target);
  EXPECT_EQ(target.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace tintree::render
