#include "render/screen_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "render/frustum.h"

namespace tintree::render {
namespace {

constexpr double kPi = std::numbers::pi;

/// Pixel position of a world point, the long way: matrices alone.
glm::dvec2 project(const Camera& camera, const glm::dvec3& p) {
  const glm::dvec4 clip = camera.projection(1, true) * camera.view_rotation() * glm::dvec4(p - camera.eye, 1);
  return {(clip.x / clip.w + 1) / 2 * camera.width_px, (1 - clip.y / clip.w) / 2 * camera.height_px};
}

bool visible(const Camera& camera, const glm::dvec3& p) {
  const glm::dvec2 at = project(camera, p);
  return glm::dot(p - camera.eye, camera.axes().forward) > 0 && at.x >= 0 && at.x <= camera.width_px && at.y >= 0 &&
         at.y <= camera.height_px;
}

class ScreenErrorTest : public testing::Test {
 protected:
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  /// Any way of looking, straight down and up among them.
  Camera any_camera() {
    Camera c;
    c.eye = {in(-500, 500), in(-500, 500), in(0, 500)};
    const double pitch = random_() % 8 == 0 ? (random_() % 2 == 0 ? -kPi / 2 : kPi / 2) : in(-kPi / 2, kPi / 2);
    const double azimuth = in(0, 2 * kPi);
    c.target =
        c.eye + glm::dvec3(std::cos(pitch) * std::sin(azimuth), std::cos(pitch) * std::cos(azimuth), std::sin(pitch));
    c.fov_y_rad = in(0.2, 1.6);
    return c;
  }

  /// A box with a part in the picture, flat ones as tiles are, and thick ones.
  cache::Box any_box(const Camera& c) {
    const glm::dvec3 middle = c.eye + in(5, 800) * c.ray(in(0, c.width_px), in(0, c.height_px));
    const double side = std::exp(in(0, 7));
    const double high = std::exp(in(-3, 5));
    cache::Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double extent = axis == 2 ? high : side;
      box.min[axis] = middle[static_cast<int>(axis)] - in(0, 1) * extent;
      box.max[axis] = box.min[axis] + extent;
    }
    return box;
  }

  /// Inside, on faces, on edges and at corners.
  glm::dvec3 any_point(const cache::Box& box) {
    glm::dvec3 p(0);
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      p[axis] = random_() % 2 == 0 ? in(box.min[a], box.max[a]) : (random_() % 2 == 0 ? box.min[a] : box.max[a]);
    }
    return p;
  }

  std::mt19937 random_{20};
};

// By brute force: of all displacements with one end in the box and one in the picture none moves farther.
TEST_F(ScreenErrorTest, BoundsEveryShiftOnTheScreen) {
  int tried = 0;
  int near = 0;
  for (int i = 0; i < 3000; ++i) {
    const Camera c = any_camera();
    const cache::Box box = any_box(c);
    const double error_m = std::exp(in(-6, 2));
    const auto bound = ScreenError(c).bound_px(box, error_m);
    double most_px = 0;
    for (int k = 0; k < 200; ++k) {
      const glm::dvec3 p = any_point(box);
      const double share = random_() % 2 == 0 ? in(-1, 1) : (random_() % 2 == 0 ? -1 : 1);
      const glm::dvec3 q = p + glm::dvec3(0, 0, share * error_m);
      if (!visible(c, p) && !visible(c, q)) continue;
      ASSERT_TRUE(bound) << i;
      const bool behind = glm::dot(q - c.eye, c.axes().forward) <= 0 || glm::dot(p - c.eye, c.axes().forward) <= 0;
      if (behind) {
        EXPECT_EQ(*bound, std::numeric_limits<double>::infinity());
      } else {
        most_px = std::max(most_px, glm::length(project(c, p) - project(c, q)));
      }
      ++tried;
    }
    if (!bound) continue;
    EXPECT_LE(most_px, *bound * (1 + 1e-9)) << i;
    near += most_px > 0.7 * *bound ? 1 : 0;
  }
  EXPECT_GT(tried, 100000);
  EXPECT_GT(near, 300);  // and it is not a bound that anything would keep
}

// Of a small box the bound is what one displacement does, but for kLeastGain.
TEST_F(ScreenErrorTest, IsTheShiftItselfOfAPoint) {
  for (int i = 0; i < 2000; ++i) {
    const Camera c = any_camera();
    const glm::dvec3 p = c.eye + in(50, 800) * c.ray(in(0, c.width_px), in(0, c.height_px));
    const cache::Box box{{p.x - 1e-5, p.y - 1e-5, p.z - 1e-5}, {p.x + 1e-5, p.y + 1e-5, p.z + 1e-5}};
    const double error_m = 1e-3;
    const double moved_px = glm::length(project(c, p + glm::dvec3(0, 0, error_m)) - project(c, p));
    const double least_px = ScreenError::kLeastGain * error_m * c.focal_px() / glm::dot(p - c.eye, c.axes().forward);
    EXPECT_NEAR(*ScreenError(c).bound_px(box, error_m) / std::max(moved_px, least_px), 1, 1e-3) << i;
  }
}

TEST_F(ScreenErrorTest, GrowsWithTheBoxAndTheError) {
  for (int i = 0; i < 3000; ++i) {
    const Camera c = any_camera();
    const cache::Box box = any_box(c);
    cache::Box part = box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double a = in(box.min[axis], box.max[axis]);
      const double b = in(box.min[axis], box.max[axis]);
      part.min[axis] = std::min(a, b);
      part.max[axis] = std::max(a, b);
    }
    const double error_m = std::exp(in(-6, 2));
    const ScreenError screen_error(c);
    const auto whole_px = screen_error.bound_px(box, error_m);
    const auto part_px = screen_error.bound_px(part, error_m);
    EXPECT_LE(part_px.value_or(0), whole_px.value_or(0) * (1 + 1e-9)) << i;
    EXPECT_LE(whole_px.value_or(0), screen_error.bound_px(box, 1.5 * error_m).value_or(0) / 1.5 * (1 + 1e-9)) << i;
  }
}

TEST_F(ScreenErrorTest, NothingIsSaidOfWhatIsOutsideThePictureAndMuchOfWhatHoldsTheEye) {
  Camera c;
  c.eye = {0, 0, 100};
  c.target = {0, 100, 100};
  const ScreenError screen_error(c);
  EXPECT_FALSE(screen_error.bound_px({{-10, -200, 0}, {10, -100, 50}}, 1));
  // No plane of the frustum has all of it outside, and yet it is: beside one corner of the picture.
  const cache::Box beside{{-90, 60, 20}, {-50, 110, 60}};
  EXPECT_EQ(screen_error.bound_px(beside, 1).has_value(), !Frustum(c).outside(beside));
  EXPECT_EQ(screen_error.bound_px({{-10, -10, 90}, {10, 10, 110}}, 1), std::numeric_limits<double>::infinity());
  EXPECT_EQ(screen_error.bound_px({{-10, -10, 90}, {10, 10, 99.5}}, 1), std::numeric_limits<double>::infinity());
  EXPECT_EQ(screen_error.bound_px({{-10, -10, 90}, {10, 10, 110}}, 0), 0);
}

}  // namespace
}  // namespace tintree::render
