#include "render/camera.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace tintree::render {
namespace {

/// Pixel position of a world point, the long way: matrices alone.
glm::dvec2 project(const Camera& camera, const glm::dvec3& p) {
  const glm::dvec4 clip = camera.projection(1, true) * camera.view_rotation() * glm::dvec4(p - camera.eye, 1);
  return {(clip.x / clip.w + 1) / 2 * camera.width_px, (1 - clip.y / clip.w) / 2 * camera.height_px};
}

Camera looking(const glm::dvec3& eye, const glm::dvec3& target) {
  Camera camera;
  camera.eye = eye;
  camera.target = target;
  return camera;
}

TEST(Camera, AxesAreRightHandedAndLevel) {
  const CameraAxes a = looking({10, -20, 30}, {-5, 40, 3}).axes();
  EXPECT_NEAR(glm::dot(a.right, a.up), 0, 1e-15);
  EXPECT_NEAR(glm::dot(a.right, a.forward), 0, 1e-15);
  EXPECT_NEAR(a.right.z, 0, 1e-15);
  EXPECT_GT(a.up.z, 0);
  EXPECT_NEAR(glm::length(glm::cross(a.right, a.up) + a.forward), 0, 1e-15);
}

TEST(Camera, StraightDownHasNorthUp) {
  const CameraAxes a = looking({100, 200, 3000}, {100, 200, 0}).axes();
  EXPECT_EQ(a.up, glm::dvec3(0, 1, 0));
  EXPECT_EQ(a.right, glm::dvec3(1, 0, 0));
}

TEST(Camera, TargetIsInTheMiddleAndRaysMatchTheMatrices) {
  const Camera camera = looking({1000, -5000, 2500}, {300, 100, 50});
  const glm::dvec2 middle = project(camera, camera.target);
  EXPECT_NEAR(middle.x, camera.width_px / 2.0, 1e-9);
  EXPECT_NEAR(middle.y, camera.height_px / 2.0, 1e-9);
  const glm::dvec2 there = project(camera, camera.eye + 777.0 * camera.ray(17, 600));
  EXPECT_NEAR(there.x, 17, 1e-7);
  EXPECT_NEAR(there.y, 600, 1e-7);
}

TEST(Camera, ReversedDepthIsNearOverDepthWithAndWithoutClipControl) {
  const Camera camera = looking({0, 0, 0}, {0, 1, 0});
  for (const double depth : {0.5, 1.0, 70.0, 1e6}) {
    const glm::dvec4 p = camera.view_rotation() * glm::dvec4(3, depth, 5, 1);
    const glm::dvec4 zero = camera.projection(0.5, true) * p;
    const glm::dvec4 minus = camera.projection(0.5, false) * p;
    EXPECT_NEAR(zero.z / zero.w, 0.5 / depth, 1e-12);
    EXPECT_NEAR((minus.z / minus.w + 1) / 2, 0.5 / depth, 1e-12);
  }
}

// The gain's promise: no vertical shift moves any visible point by more pixels than it says.
TEST(Camera, VerticalGainBoundsEveryShiftOnTheScreen) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> in(0, 1);
  for (int i = 0; i < 20000; ++i) {
    const double pitch = (in(random)-0.5) * std::numbers::pi;
    Camera camera = looking({5, 6, 7}, {5 + std::cos(pitch), 6, 7 + std::sin(pitch)});
    camera.fov_y_rad = 0.2 + in(random);
    const glm::dvec2 pixel(in(random)*camera.width_px, in(random)*camera.height_px);
    const double depth = 10 + 1000 * in(random);
    const glm::dvec3 p = camera.eye + depth * camera.ray(pixel.x, pixel.y);
    const double shift_m = 1e-4;  // Small, so that the depth stays what it was.
    const double moved_px = glm::length(project(camera, p + glm::dvec3(0, 0, shift_m)) - pixel);
    EXPECT_LE(moved_px, shift_m * camera.focal_px() / depth * camera.vertical_gain() * 1.0001);
  }
}

TEST(Camera, OverviewShowsEveryPointAndFillsTheFrame) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> in(-1, 1);
  for (const double height : {10.0, 3000.0}) {
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 200; ++i)
      points.emplace_back(5e4 + 4e4 * in(random), -3e4 + 2e4 * in(random), height * in(random));
    const Camera camera = overview(points, std::numbers::pi, 0.7, 800, 600, 0.02);
    double least_margin = 1;
    for (const glm::dvec3& p : points) {
      const glm::dvec2 at = project(camera, p);
      const double margin = std::min({at.x / 800, 1 - at.x / 800, at.y / 600, 1 - at.y / 600});
      EXPECT_GE(margin, 0.02 - 1e-9);
      least_margin = std::min(least_margin, margin);
    }
    EXPECT_NEAR(least_margin, 0.02, 1e-6);
    EXPECT_LT(camera.eye.y, camera.target.y);
    EXPECT_NEAR(std::asin(-camera.axes().forward.z), 0.7, 1e-9);
  }
}

}  // namespace
}  // namespace tintree::render
