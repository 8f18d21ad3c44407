/// A tree of method `nested` as a scene under OSMesa: within the pixel error, no gap, no jump, no more memory than
/// given.

#include "render/nested_drawer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <gtest/gtest.h>

#include "codec/nested_mesh.h"
#include "render/terrain_scene.h"
#include "tests/render/osmesa_test.h"
#include "tests/render/seen.h"
#include "tests/render/write_tree.h"
#include "tests/support/nested_tree.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

using test::NestedTree;

constexpr int kWidth = 161;
constexpr int kHeight = 121;

class NestedSceneTest : public OsMesaTest {
 protected:
  void SetUp() override {
    test::write_tree(dir_.file("nested.tintree"), "nested", codec::NestedMesh(), NestedTree());
    store_.emplace(std::move(*cache::TileStore::open(dir_.file("nested.tintree"))));
    target_.emplace(std::move(*OffscreenTarget::create(gl_, kWidth, kHeight, 1)));
    style_.background = glm::vec3(1, 0, 1);
  }

  void open(double pixel_error, bool morph, std::size_t gpu_bytes = std::size_t{64} << 20,
            Occlusion occlusion = Occlusion::kOff) {
    SceneOptions options;
    options.occlusion = occlusion;
    options.cut = {.pixel_error = pixel_error, .morph = morph};
    options.gpu_bytes = gpu_bytes;
    auto made = TerrainScene::create(gl_, *store_, options);
    ASSERT_TRUE(made) << made.error().text();
    scene_ = std::move(*made);
  }

  static Camera camera(const glm::dvec3& eye, const glm::dvec3& target) {
    Camera c = test::camera_at(eye, target, kWidth, kHeight);
    c.fov_y_rad = 0.6;
    return c;
  }
  /// Views of the ground alone.
  static std::vector<Camera> views() {
    std::vector<Camera> out;
    for (int i = 0; i < 8; ++i) {
      const glm::dvec3 eye(480 + 23 * i, -760 + 17 * i, 460 - 30 * i);
      out.push_back(camera(eye, eye + glm::dvec3(120, 110, -190)));
    }
    return out;
  }

  void draw(const Camera& camera) {
    auto cut = scene_->settle(camera);
    ASSERT_TRUE(cut) << cut.error().text();
    cut_ = *cut;
    stats_ = scene_->draw(*target_, camera, cut_, style_);
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
  }

  /// Where a ray, one long in depth, first meets the ground, endless on all sides: by steps that jump over nothing
  /// seen.
  static double first_ground(const glm::dvec3& eye, const glm::dvec3& ray) {
    const auto above_m = [&](double t) {
      return eye.z + t * ray.z - NestedTree::ground_m(eye.x + t * ray.x, eye.y + t * ray.y);
    };
    constexpr double kHighest_m = 64;
    double to = ray.z < 0 ? std::max(0.0, (kHighest_m - eye.z) / ray.z) : 1e5;
    double from = to;
    while (above_m(to) > 0 && to < 1e5) {
      from = to;
      to += 0.5;
    }
    for (int i = 0; i < 40; ++i) {
      const double middle = (from + to) / 2;
      (above_m(middle) > 0 ? from : to) = middle;
    }
    return to;
  }

  static int count_magenta(const Picture& p) {
    int count = 0;
    for (std::size_t i = 0; i < p.rgb.size(); i += 3)
      count += p.rgb[i] == 255 && p.rgb[i + 1] == 0 && p.rgb[i + 2] == 255;
    return count;
  }

  test::TempDir dir_;
  std::optional<cache::TileStore> store_;
  std::optional<OffscreenTarget> target_;
  std::unique_ptr<TerrainScene> scene_;
  Style style_;
  LodCut cut_;
  DrawStats stats_;
};

/// By the depth buffer, against the ground itself: what is drawn is as far off as the pixels allow.
TEST_F(NestedSceneTest, KeepsThePixelErrorByCoarserLevels) {
  for (const bool morph : {false, true}) {
    const double pixel_error = 12;
    open(pixel_error, morph);
    std::set<int> levels;
    double worst = 0;
    for (int i = 0; i < 6; ++i) {
      const glm::dvec3 eye(200 + 60 * i, -1180, 130 + 40 * i);
      const Camera c = camera(eye, eye + glm::dvec3(60, 200, -60));
      draw(c);
      for (const DrawTile& d : cut_.draws) levels.insert(d.nested_level);
      const CameraAxes axes = c.axes();
      for (int y = 3; y < kHeight; y += 7) {
        for (int x = 2; x < kWidth; x += 7) {
          const double stored = target_->read_depth(x, y);
          if (stored <= 0) continue;
          const double depth = scene_->renderer().near_m(cut_) / stored;
          const double right = (x + 0.5 - kWidth / 2.0) / c.focal_px();
          const double up = (kHeight / 2.0 - y - 0.5) / c.focal_px();
          const glm::dvec3 at = c.eye + depth * (axes.forward + right * axes.right + up * axes.up);
          if (at.x < 1 || at.x > 1279 || at.y > -1 || at.y < -1279) continue;
          const double allowed_m = std::max(pixel_error * depth / c.focal_px(), NestedTree::error_m(2));
          worst = std::max(worst, std::abs(at.z - NestedTree::ground_m(at.x, at.y)) / allowed_m);
        }
      }
    }
    EXPECT_LT(worst, 1.05) << morph;
    EXPECT_GT(levels.size(), 1U) << "all tiles were drawn by one level";
    EXPECT_GT(worst, 0.1) << "nothing was coarse";
  }
}

/// Against rays at the ground itself, from so far away that the leaves are good for a pixel.
TEST_F(NestedSceneTest, KeepsWithinOnePixelOfTheGround) {
  constexpr double kMargin_m = 100;  // Of the outline, which a ray may pass over within the pixel.
  for (const bool morph : {false, true}) {
    open(1, morph);
    std::set<int> levels;
    double worst_px = 0;
    int compared = 0;
    for (int i = 0; i < 6; ++i) {
      const double away_m = 2800 + 500 * i;
      const double azimuth = 0.7 + i;
      const glm::dvec3 target(640, -640, 0);
      const glm::dvec3 towards_eye(0.85 * std::sin(azimuth), 0.85 * std::cos(azimuth), std::sqrt(1 - 0.85 * 0.85));
      const Camera c = camera(target + away_m * towards_eye, target);
      draw(c);
      for (const DrawTile& d : cut_.draws) levels.insert(d.nested_level);
      const CameraAxes axes = c.axes();
      const auto on_screen = [&](const glm::dvec3& p) {
        const glm::dvec3 from_eye = p - c.eye;
        return c.focal_px() / glm::dot(from_eye, axes.forward) *
               glm::dvec2(glm::dot(from_eye, axes.right), glm::dot(from_eye, axes.up));
      };
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const glm::dvec3 ray = c.ray(x + 0.5, y + 0.5);
          const glm::dvec3 seen = c.eye + first_ground(c.eye, ray) * ray;
          const double outside_m = std::max(std::abs(seen.x - 640), std::abs(seen.y + 640)) - 640;
          if (outside_m > -kMargin_m) continue;
          const double stored = target_->read_depth(x, y);
          ASSERT_GT(stored, 0) << "a hole at " << x << ", " << y;
          const glm::dvec3 drawn = c.eye + scene_->renderer().near_m(cut_) / stored * ray;
          const glm::dvec3 ground(drawn.x, drawn.y, NestedTree::ground_m(drawn.x, drawn.y));
          worst_px = std::max(worst_px, glm::length(on_screen(drawn) - on_screen(ground)));
          ++compared;
        }
      }
    }
    EXPECT_LE(worst_px, 1) << morph;
    EXPECT_GT(worst_px, 0.2) << "nothing was coarse";
    EXPECT_GT(levels.size(), 1U) << "all tiles were drawn by one level";
    EXPECT_GT(compared, kWidth * kHeight / 2);
  }
}

/// By the stitches alone: skirts have nothing to hide.
TEST_F(NestedSceneTest, HasNoGapBetweenTiles) {
  int open_px = 0;
  style_.skirts = false;
  for (const bool morph : {false, true}) {
    for (const double pixel_error : {5.0, 9.0}) {
      open(pixel_error, morph);
      for (const Camera& c : views()) {
        style_.stitches = true;
        draw(c);
        EXPECT_EQ(count_magenta(target_->read_picture()), 0) << "pixel error " << pixel_error << ", morph " << morph;
        style_.stitches = false;
        draw(c);
        open_px += count_magenta(target_->read_picture());
      }
    }
  }
  EXPECT_GT(open_px, 0) << "there was nothing to stitch";
}

/// A slow flight, stopped wherever other tiles or other meshes are drawn than just before: between two such places the
/// picture changes steadily, with the camera.
class NestedFlight : public NestedSceneTest {
 protected:
  static constexpr int kFrames = 60;

  static Camera at(double frame) {
    const glm::dvec3 eye(500 + frame, -1500 + 5 * frame, 330);
    return camera(eye, eye + glm::dvec3(60, 200, -130));
  }

  using Meshes = std::vector<std::pair<std::uint32_t, int>>;
  Meshes meshes_at(double frame) {
    Meshes out;
    const auto cut = scene_->settle(at(frame));
    for (const DrawTile& d : cut->draws) out.emplace_back(d.node, d.nested_level);
    return out;
  }

  Picture picture_at(double frame) {
    draw(at(frame));
    return target_->read_picture();
  }

  /// How many greys the picture changes by, on average, at each of those places, with the camera at rest.
  std::vector<double> jumps() {
    std::vector<double> out;
    double from = 0;
    for (int i = 1; i <= kFrames; ++i) {
      for (Meshes before = meshes_at(from); before != meshes_at(i); before = meshes_at(from)) {
        double to = i;
        while (to - from > 1e-10) {
          const double middle = (from + to) / 2;
          (meshes_at(middle) == before ? from : to) = middle;
        }
        const Picture a = picture_at(from);
        const Picture b = picture_at(to);
        double sum = 0;
        for (std::size_t k = 0; k < a.rgb.size(); ++k) sum += std::abs(int{a.rgb[k]} - int{b.rgb[k]});
        out.push_back(sum / static_cast<double>(a.rgb.size()));
        from = to;
      }
      from = i;
    }
    return out;
  }
};

TEST_F(NestedFlight, MorphsWithoutAJump) {
  open(5, true);
  const std::vector<double> morphing = jumps();
  open(5, false);
  const std::vector<double> jumping = jumps();
  EXPECT_GT(morphing.size(), 4U) << "the same was drawn all the way";
  EXPECT_LT(std::ranges::max(morphing), std::ranges::max(jumping) / 10);
}

/// From low over the ground, where hills stand before hills.
TEST_F(NestedSceneTest, WhatIsHiddenChangesNothing) {
  std::uint32_t hidden = 0;
  std::set<int> levels;
  for (const bool morph : {false, true}) {
    for (const double pixel_error : {1.0, 4.0}) {
      std::vector<Picture> whole;
      for (const Occlusion occlusion : {Occlusion::kOff, Occlusion::kAlways}) {
        open(pixel_error, morph, std::size_t{64} << 20, occlusion);
        for (int i = 0; i < 4; ++i) {
          const double x = 200 + 230 * i;
          const double y = -1250 + 90 * i;
          const glm::dvec3 eye(x, y, NestedTree::ground_m(x, y) + 4 + 3 * i);
          draw(camera(eye, eye + glm::dvec3(30 - 20 * i, 300, -12)));
          for (const DrawTile& d : cut_.draws) levels.insert(d.nested_level);
          hidden += cut_.occluded;
          const Picture seen = target_->read_picture();
          if (occlusion == Occlusion::kOff) {
            EXPECT_EQ(cut_.occluded, 0U);
            whole.push_back(seen);
          } else {
            EXPECT_EQ(seen.rgb, whole[static_cast<std::size_t>(i)].rgb) << i << ", pixel error " << pixel_error;
          }
        }
      }
    }
  }
  EXPECT_GT(hidden, 10U) << "nothing was hidden";
  EXPECT_GT(levels.size(), 1U) << "all tiles were drawn by their own meshes";
}

TEST_F(NestedSceneTest, DrawsCoarserWithinTheMemory) {
  constexpr std::size_t kBytes = std::size_t{512} << 10;
  open(0, false);
  draw(views().front());
  const std::uint64_t all = stats_.triangles;
  open(0, false, kBytes);
  for (const Camera& c : views()) {
    draw(c);
    EXPECT_EQ(count_magenta(target_->read_picture()), 0);
    EXPECT_LE(scene_->pool().reserved_bytes(), kBytes);
  }
  EXPECT_LT(stats_.triangles, all);
}

}  // namespace
}  // namespace tintree::render
