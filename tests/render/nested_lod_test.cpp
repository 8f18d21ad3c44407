#include "render/nested_lod.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace tintree::render {
namespace {

TEST(NestedLod, LevelIsLinearInTheErrorBetweenPowersOfTwo) {
  EXPECT_EQ(level_for(0), 8);
  EXPECT_EQ(level_for(0.7F), 8);
  for (int i = 0; i < 8; ++i) {
    const float bounds = std::ldexp(1.0F, i);
    EXPECT_FLOAT_EQ(level_for(bounds), static_cast<float>(8 - i));
    EXPECT_FLOAT_EQ(level_for(1.25F * bounds), 7.75F - static_cast<float>(i));
    EXPECT_FLOAT_EQ(level_for(1.5F * bounds), 7.5F - static_cast<float>(i));
  }
}

TEST(NestedLod, WeightsAreThePiecewiseLinearInterpolation) {
  for (float level = 0; level <= 8; level += 0.125F) {
    const auto weights = morph_weights(level);
    for (int i = 0; i <= 8; ++i) {
      const float hat = std::max(0.0F, 1 - std::abs(level - static_cast<float>(i)));
      EXPECT_FLOAT_EQ(weights[static_cast<std::size_t>(i)], hat) << level << ", weight " << i;
    }
  }
}

/// What the surface's error may be at a level is what its weights make of the levels' errors.
TEST(NestedLod, ErrorOfTheMixedSurfaceIsTheOneAllowed) {
  for (float bounds = 1; bounds < 256; bounds *= 1.07F) {
    const auto weights = morph_weights(level_for(bounds));
    float error = 0;
    for (int i = 0; i <= 8; ++i) error += weights[static_cast<std::size_t>(i)] * std::ldexp(1.0F, 8 - i);
    EXPECT_NEAR(error, bounds, 1e-4F * bounds);
  }
}

/// The mesh of a box holds what any vertex in view in it asks for, and one level less would not do.
TEST(NestedLod, MeshLevelKeepsThePixelError) {
  std::mt19937 random(2);
  const auto real = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
  };
  int coarser = 0;
  for (int i = 0; i < 300; ++i) {
    Camera camera;
    camera.eye = {real(-900, 900), real(-900, 900), real(100, 900)};
    camera.target = {real(-900, 900), real(-900, 900), real(-50, 50)};
    camera.fov_y_rad = real(0.3, 1.5);
    const ScreenError screen_error(camera);
    const glm::dvec3 corner(real(-900, 900), real(-900, 900), real(-50, 50));
    const double width = real(1, 800);
    const cache::Box box{{corner.x, corner.y, corner.z}, {corner.x + width, corner.y + width, corner.z + 90}};
    constexpr double kBound_m = 0.1;
    const int level = mesh_level(screen_error, box, kBound_m, 2);
    coarser += level < 8 ? 1 : 0;
    if (level == 8) continue;
    const CameraAxes axes = camera.axes();
    for (int j = 0; j < 20; ++j) {
      const glm::dvec3 at = corner + glm::dvec3(real(0, width), real(0, width), real(0, 90)) - camera.eye;
      const double depth = glm::dot(axes.forward, at);
      const glm::dvec2 seen(glm::dot(axes.right, at) / depth, glm::dot(axes.up, at) / depth);
      if (depth <= 0 || std::abs(seen.x) > camera.tan_half_x() || std::abs(seen.y) > camera.tan_half_y()) continue;
      const double gain = std::max(1.0, glm::length(glm::cross(axes.forward, glm::dvec3(-at.y, at.x, 0))) / depth);
      const double allowed = 2 * depth / (camera.focal_px() * gain * kBound_m);
      EXPECT_LE(level_for(static_cast<float>(allowed)), static_cast<float>(level) + 1e-4F);
    }
  }
  EXPECT_GT(coarser, 20);
}

}  // namespace
}  // namespace tintree::render
