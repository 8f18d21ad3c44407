#include "render/terrain_scene.h"

#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "tests/render/osmesa_test.h"
#include "tests/render/seen.h"
#include "tests/render/analytic_tree.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

constexpr int kWidth = 240;
constexpr int kHeight = 160;

/// A square of analytic terrain at a place of the world's height function, cut out of it as gdal_translate would.
struct Piece {
  std::int64_t column = 0;
  std::int64_t row = 0;
  std::int64_t columns = 129;
  std::int64_t rows = 129;
};

double height_m(double x, double y) {
  return 60 * std::sin(x / 170) * std::cos(y / 130) + 25 * std::sin(x / 41 + y / 57);
}

class SceneTest : public OsMesaTest {
 protected:
  /// Writes a tree of a piece of the terrain, georeferenced from `origin` in metres.
  cache::TileStore tree(const Piece& piece, std::array<double, 2> origin = {0, 0}, double spacing_m = 10,
                        double lift_m = 0, double stretch = 1) {
    test::AnalyticTree t;
    t.columns = piece.columns;
    t.rows = piece.rows;
    t.spacing_m = spacing_m;
    const double x0 = static_cast<double>(piece.column) * spacing_m;
    const double y0 = -static_cast<double>(piece.row) * spacing_m;
    const double scale = 10 / spacing_m;
    t.height_m = [=](double x, double y) { return stretch * (lift_m + height_m((x0 + x) * scale, (y0 + y) * scale)); };
    t.geotransform = {origin[0] + x0 - spacing_m / 2, spacing_m, 0, origin[1] + y0 + spacing_m / 2, 0, -spacing_m};
    const std::string path = dir_.file("tree" + std::to_string(written_++) + ".tintree");
    t.write(path);
    return std::move(*cache::TileStore::open(path));
  }

  static std::unique_ptr<TerrainScene> scene(const std::vector<const cache::TileStore*>& stores,
                                             const SceneOptions& options = {}) {
    auto made = TerrainScene::create(gl_, stores, options);
    EXPECT_TRUE(made) << made.error().text();
    return std::move(*made);
  }

  static Camera camera(const glm::dvec3& eye, const glm::dvec3& target) {
    return test::camera_at(eye, target, kWidth, kHeight);
  }

  static Picture settled_picture(TerrainScene& scene, const Camera& camera) {
    const auto cut = scene.settle(camera);
    EXPECT_TRUE(cut) << cut.error().text();
    return picture(scene, camera, *cut);
  }

  static Picture picture(TerrainScene& scene, const Camera& camera, const LodCut& cut) {
    const auto target = OffscreenTarget::create(gl_, kWidth, kHeight, 1);
    EXPECT_TRUE(target);
    Style style;
    style.background = glm::vec3(1, 0, 1);
    scene.draw(*target, camera, cut, style);
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    return target->read_picture();
  }

  static int count_magenta(const Picture& p) {
    int count = 0;
    for (std::size_t i = 0; i < p.rgb.size(); i += 3)
      count += p.rgb[i] == 255 && p.rgb[i + 1] == 0 && p.rgb[i + 2] == 255;
    return count;
  }

  /// Views into the middle of 129 x 129 samples of 10 m, all ground.
  static std::vector<Camera> views() {
    std::vector<Camera> out;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> in(0, 1);
    for (int i = 0; i < 24; ++i) {
      const double turn = 2 * 3.14159265 * in(random);
      const glm::dvec3 target(520 + 240 * in(random), -520 - 240 * in(random), 20);
      const double away = 60 + 140 * in(random);
      out.push_back(camera(target + glm::dvec3(away * std::sin(turn), away * std::cos(turn), 200 + away), target));
    }
    return out;
  }

  test::TempDir dir_;
  int written_ = 0;
};

// The paper's three trees: the ground of one raster cut into four pieces, drawn as one.
TEST_F(SceneTest, PiecesAreDrawnAsOneWithoutASeam) {
  const std::array<double, 2> origin{500000, 4000000};
  const cache::TileStore whole = tree({}, origin);
  const cache::TileStore nw = tree({0, 0, 65, 65}, origin);
  const cache::TileStore ne = tree({64, 0, 65, 65}, origin);
  const cache::TileStore sw = tree({0, 64, 65, 65}, origin);
  const cache::TileStore se = tree({64, 64, 65, 65}, origin);
  const auto one = scene({&whole});
  const auto four = scene({&nw, &ne, &sw, &se});
  int differing = 0;
  for (const Camera& c : views()) {
    const Picture a = settled_picture(*one, c);
    const Picture b = settled_picture(*four, c);
    EXPECT_EQ(count_magenta(a), 0);
    EXPECT_EQ(count_magenta(b), 0);
    for (std::size_t i = 0; i < a.rgb.size(); ++i) differing += std::abs(a.rgb[i] - b.rgb[i]) > 24 ? 1 : 0;
  }
  // Other tiles are simplified otherwise, within a pixel; the light on them differs a little.
  EXPECT_LT(differing, static_cast<int>(views().size()) * kWidth * kHeight * 3 / 50);
}

// Quarter-metre spacing in UTM coordinates: what is drawn depends on differences to the eye alone.
TEST_F(SceneTest, ThePictureDoesNotDependOnTheOrigin) {
  const Piece piece;
  const cache::TileStore here = tree(piece, {0, 0}, 0.25, 0, 0.025);
  // A first tree four thousand kilometres away, which makes the second's coordinates large.
  const cache::TileStore anchor = tree({0, 0, 5, 5}, {0, 0}, 0.25, 0, 0.025);
  const cache::TileStore far = tree(piece, {500000, 4000000}, 0.25, 0, 0.025);
  const auto near_scene = scene({&here});
  const auto far_scene = scene({&anchor, &far});
  const glm::dvec3 shift(500000, 4000000, 0);
  for (int step = 0; step < 4; ++step) {
    const Camera c = camera({13 + 0.001 * step, -19, 3.5}, {16.3, -15, 0.4});
    const Picture a = settled_picture(*near_scene, c);
    const Picture b = settled_picture(*far_scene, camera(c.eye + shift, c.target + shift));
    int most = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) most = std::max(most, std::abs(a.rgb[i] - b.rgb[i]));
    EXPECT_LE(most, 6) << step;
    EXPECT_LT(count_magenta(a), kWidth * kHeight / 2);
  }
}

TEST_F(SceneTest, WhatIsOnTheScreenDependsOnTheCameraAlone) {
  const cache::TileStore store = tree({});
  const std::vector<Camera> all = views();
  std::vector<Picture> alone;
  for (std::size_t i = 0; i < 6; ++i) alone.push_back(settled_picture(*scene({&store}), all[i]));
  SceneOptions options;
  options.upload_bytes = 1;  // Parents stand in for many frames.
  const auto s = scene({&store}, options);
  std::mt19937 random(5);
  for (int step = 0; step < 40; ++step) {
    const std::size_t i = random() % 6;
    if (step % 2 == 0) s->update(all[random() % all.size()], 0.1 * step);
    EXPECT_EQ(settled_picture(*s, all[i]).rgb, alone[i].rgb) << step;
  }
}

// Without waiting, a tile a frame: from the first frame that has the root on there is ground wherever ground belongs.
TEST_F(SceneTest, HolesNeverShowWhileTilesCome) {
  const cache::TileStore store = tree({});
  SceneOptions options;
  options.upload_bytes = 1;
  const auto s = scene({&store}, options);
  const std::vector<Camera> all = views();
  ASSERT_TRUE(s->settle(camera({640, -640, 1e6}, {641, -640, 0})));
  int incomplete = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const LodCut cut = s->update(all[i], 0.01 * static_cast<double>(i));
    incomplete += cut.complete ? 0 : 1;
    EXPECT_EQ(count_magenta(picture(*s, all[i], cut)), 0) << i;
  }
  EXPECT_GT(incomplete, 3);
}

// With overlays, too, which are as large as several tiles.
TEST_F(SceneTest, NothingIsAllocatedOnceTheMemoryIsFull) {
  const cache::TileStore store = tree({0, 0, 257, 257});
  for (const bool morph : {false, true}) {
    SceneOptions options;
    options.cut = {.pixel_error = 0, .morph = morph};
    options.gpu_bytes = (morph ? std::size_t{3} : std::size_t{1}) << 20;
    options.cache_bytes = std::size_t{2} << 20;
    const auto s = scene({&store}, options);
    std::size_t largest = 0;
    for (int i = 0; i < 60; ++i) {
      const double x = 100 + 80.0 * (i % 20);
      const double y = -300 - 30.0 * i;
      const Camera c = camera({x, y, 200}, {x, y - 1, 0});
      const auto cut = s->settle(c);
      ASSERT_TRUE(cut);
      std::size_t bytes = 0;
      for (const DrawTile& d : cut->draws) bytes += s->cache().get({s->bounds().nodes()[d.node].id})->bytes();
      EXPECT_GE(s->pool().bytes(), bytes / 2) << "everything that is drawn counts";
      EXPECT_LE(s->pool().bytes(), s->pool().reserved_bytes());
      EXPECT_LE(s->pool().reserved_bytes(), options.gpu_bytes);
      if (i == 20) largest = s->pool().reserved_bytes();
      if (i > 20) {
        EXPECT_EQ(s->pool().reserved_bytes(), largest);
      }
    }
  }
}

// A card with too little memory shows coarser ground, but all of it; with enough again nothing is left of that.
TEST_F(SceneTest, TooLittleMemoryDrawsCoarserAndSaysSo) {
  const cache::TileStore store = tree({0, 0, 257, 257});
  const Camera c = camera({1280, -1280, 1800}, {1280, -1279.999, 0});
  SceneOptions options;
  options.cut.pixel_error = 0;
  options.gpu_bytes = std::size_t{1} << 20;
  const auto s = scene({&store}, options);
  EXPECT_EQ(count_magenta(settled_picture(*s, c)), 0);
  EXPECT_TRUE(s->frame_stats().gpu_memory_full);
  EXPECT_LE(s->pool().bytes(), options.gpu_bytes);
  SceneOptions roomy_options;
  roomy_options.cut.pixel_error = 0;
  const auto roomy = scene({&store}, roomy_options);
  settled_picture(*roomy, c);
  EXPECT_FALSE(roomy->frame_stats().gpu_memory_full);
  EXPECT_GT(roomy->pool().bytes(), options.gpu_bytes);
}

TEST_F(SceneTest, CountsHitsMissesAndUploads) {
  const cache::TileStore store = tree({});
  const auto s = scene({&store});
  const Camera c = views().front();
  LodCut cut = s->update(c, 0);
  EXPECT_EQ(s->frame_stats().cache_misses, cut.requests.size());
  EXPECT_EQ(s->frame_stats().cache_hits, 0U);
  std::uint32_t uploads = 0;
  std::uint64_t bytes = s->frame_stats().bytes_read;
  for (int i = 1; i < 3000 && !cut.complete; ++i) {
    s->cache().wait_idle();
    cut = s->update(c, 0.001 * i);
    uploads += s->frame_stats().uploads;
    bytes += s->frame_stats().bytes_read;
    EXPECT_EQ(s->frame_stats().cache_hits, 0U);
  }
  ASSERT_TRUE(cut.complete);
  EXPECT_GE(uploads, cut.draws.size());
  EXPECT_GT(bytes, 0U);
}

// Planet-size extents: the ground under the eye keeps its place beside a horizon thousands of kilometres away.
TEST_F(SceneTest, APlanetsExtentHasItsPrecision) {
  const cache::TileStore store = tree({0, 0, 129, 129}, {0, 0}, 80000, 85, 1000);
  const auto s = scene({&store});
  const Camera c = camera({5e6, -5.1e6, 240000}, {5e6, -5e6, 180000});
  const auto cut = s->settle(c);
  ASSERT_TRUE(cut);
  const auto target = OffscreenTarget::create(gl_, kWidth, kHeight, 1);
  ASSERT_TRUE(target);
  s->draw(*target, c, *cut, {});
  const auto stored = static_cast<double>(target->read_depth(kWidth / 2, kHeight - 10));
  ASSERT_GT(stored, 0);
  const glm::dvec3 p = c.eye + s->renderer().near_m(*cut) / stored * c.ray(kWidth / 2 + 0.5, kHeight - 9.5);
  EXPECT_NEAR(p.z, 1000 * (85 + height_m(p.x / 8000, p.y / 8000)), 3500);  // Two hundredths of the relief.
}

}  // namespace
}  // namespace tintree::render
