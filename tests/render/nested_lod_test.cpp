#include "render/nested_lod.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

namespace tintree::render {
namespace {

/// By the matrices that the graphics card gets: pixels, and depth.
glm::dvec3 project(const Camera& camera, const glm::dvec3& point) {
  const glm::dvec4 clip = camera.projection(1, true) * camera.view_rotation() * glm::dvec4(point - camera.eye, 1);
  return {clip.x / clip.w * camera.width_px / 2, clip.y / clip.w * camera.height_px / 2, clip.w};
}

struct View {
  Camera camera;
  glm::dvec3 point;
};

View random_view(std::mt19937& random) {
  const auto real = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
  };
  View out;
  out.camera.eye = {real(-900, 900), real(-900, 900), real(100, 900)};
  out.camera.target = {real(-900, 900), real(-900, 900), real(-50, 50)};
  out.camera.fov_y_rad = real(0.3, 1.8);
  out.camera.width_px = 1024;
  out.camera.height_px = 768;
  const double depth = real(20, 5000);
  const glm::dvec3 ray = out.camera.ray(real(0, 1024), real(0, 768));
  out.point = out.camera.eye + depth * ray;
  return out;
}

TEST(NestedLod, ScaleIsThatOfFiniteDifferences) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const auto [camera, point] = random_view(random);
    const double step = 1e-4 * glm::length(point - camera.eye);
    glm::dmat3 jacobian;
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 aside(0);
      aside[axis] = step;
      jacobian[axis] = (project(camera, point + aside) - project(camera, point - aside)) / (2 * step);
    }
    const double angle = 0.1 * i;
    const glm::dvec2 along(std::cos(angle), std::sin(angle));
    const double expected = glm::length(glm::inverse(jacobian) * glm::dvec3(along, 0));
    EXPECT_NEAR(lod_scale_m(camera, point, along), expected, 1e-5 * expected);
    EXPECT_NEAR(lod_scale_m(camera, point, 7.0 * along), expected, 1e-5 * expected);
  }
}

TEST(NestedLod, WantsTheFinestBehindTheEye) {
  Camera camera;
  EXPECT_EQ(lod_scale_m(camera, {0, -5, 0}), 0);
  std::array<glm::dvec3, 8> corners{};
  corners.fill({0, -5, 0});
  for (const float level : corner_levels(camera, corners, 1, 9, 1)) EXPECT_GT(level, 100);
}

/// A box in view of a camera, and the level of a point in it.
TEST(NestedLod, AllowsNoMoreThanThePixelErrorInsideTheBox) {
  std::mt19937 random(2);
  constexpr int kLevels = 9;
  for (int i = 0; i < 300; ++i) {
    const auto [camera, point] = random_view(random);
    std::array<glm::dvec3, 8> corners{};
    const double width = 1 + static_cast<double>(random() % 800);
    for (std::size_t k = 0; k < 8; ++k) {
      corners[k] = point + glm::dvec3((k & 1) != 0 ? width : 0, (k & 2) != 0 ? -width : 0, (k & 4) != 0 ? 90 : 0);
    }
    const double bound_m = 0.1;
    const CornerLevels levels = corner_levels(camera, corners, bound_m, kLevels, 2);
    for (int j = 0; j < 10; ++j) {
      const std::array<float, 3> at{static_cast<float>(random() % 101) / 100, static_cast<float>(random() % 101) / 100,
                                    static_cast<float>(random() % 101) / 100};
      const glm::dvec3 inside = corners[0] + glm::dvec3(width * at[0], -width * at[1], 90.0 * at[2]);
      const glm::dvec3 seen = project(camera, inside);
      if (seen.z < 1 || std::abs(seen.x) > 512 || std::abs(seen.y) > 384) continue;
      const double level = level_at(levels, at);
      const double tolerance = bound_m * std::exp2(kLevels - 1 - level);
      if (level < 0 || level > 40) continue;  // No such tolerance exists.
      const glm::dvec3 moved = project(camera, inside + glm::dvec3(0, 0, 1e-3 * tolerance));
      EXPECT_LE(1e3 * std::hypot(moved.x - seen.x, moved.y - seen.y), 2 * 1.001);
    }
  }
}

TEST(NestedLod, MeshHoldsWhatTheCornersWant) {
  CornerLevels corners{};
  corners.fill(2);
  EXPECT_EQ(mesh_level(corners, 9), 2);
  corners[5] = 4.1F;
  EXPECT_EQ(mesh_level(corners, 9), 5);
  corners[5] = 40;
  EXPECT_EQ(mesh_level(corners, 9), 8);
  corners.fill(-3);
  EXPECT_EQ(mesh_level(corners, 9), 0);
}

TEST(NestedLod, LevelIsTrilinear) {
  CornerLevels corners{};
  for (std::size_t k = 0; k < 8; ++k) {
    corners[k] = (k & 1 ? 2.0F : 0.0F) + (k & 2 ? 3.0F : 0.0F) + (k & 4 ? 5.0F : 0.0F);
  }
  EXPECT_FLOAT_EQ(level_at(corners, {0.25F, 0.5F, 0.75F}), 0.5F + 1.5F + 3.75F);
  corners = {};
  corners[6] = 8;
  EXPECT_FLOAT_EQ(level_at(corners, {0.25F, 0.5F, 0.75F}), 8 * 0.75F * 0.5F * 0.75F);
}

TEST(NestedLod, WeightsAreThePiecewiseLinearInterpolation) {
  for (int levels = 1; levels <= codec::NestedTile::kMostLevels; ++levels) {
    for (float level = -1; level < 12; level += 0.125F) {
      const auto weights = morph_weights(level, levels);
      const float at = std::clamp(level, 0.0F, static_cast<float>(levels - 1));
      for (int i = 0; i < codec::NestedTile::kMostLevels; ++i) {
        const float hat = std::max(0.0F, 1 - std::abs(at - static_cast<float>(i)));
        EXPECT_FLOAT_EQ(weights[static_cast<std::size_t>(i)], hat) << level << " of " << levels << ", weight " << i;
      }
    }
  }
}

}  // namespace
}  // namespace tintree::render
