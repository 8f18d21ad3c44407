#include "render/frustum.h"

#include <algorithm>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace tintree::render {
namespace {

bool visible(const Camera& camera, const glm::dvec3& p) {
  const CameraAxes a = camera.axes();
  const glm::dvec3 q = p - camera.eye;
  const double depth = glm::dot(q, a.forward);
  return depth > 0 && std::abs(glm::dot(q, a.right)) <= depth * camera.tan_half_x() &&
         std::abs(glm::dot(q, a.up)) <= depth * camera.tan_half_y();
}

// Against brute force: no box that holds a visible point is culled, and no visible point is nearer than said.
TEST(Frustum, IsConservative) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> in(0, 1);
  int culled = 0;
  for (int i = 0; i < 4000; ++i) {
    Camera camera;
    camera.eye = {100 * in(random), 100 * in(random), 100 * in(random)};
    camera.target = {100 * in(random), 100 * in(random), 100 * in(random)};
    const Frustum frustum(camera);
    cache::Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.min[axis] = 200 * in(random)-50;
      box.max[axis] = box.min[axis] + 60 * in(random);
    }
    const bool outside = frustum.outside(box);
    culled += outside ? 1 : 0;
    const double nearest = frustum.nearest_depth_m(box);
    for (int k = 0; k < 60; ++k) {
      glm::dvec3 p(0);
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        // The corners first, then points inside.
        const double share = k < 8 ? (k >> axis & 1) : in(random);
        p[axis] = box.min[a] + share * (box.max[a] - box.min[a]);
      }
      if (!visible(camera, p)) continue;
      EXPECT_FALSE(outside);
      const double depth = glm::dot(p - camera.eye, camera.axes().forward);
      EXPECT_GE(depth, nearest - 1e-9);
      EXPECT_LE(depth, frustum.farthest_depth_m(box) + 1e-9);
    }
  }
  EXPECT_GT(culled, 1000);
}

TEST(Frustum, CullsWhatIsBehindAndBeside) {
  Camera camera;  // From the origin to the north.
  const Frustum frustum(camera);
  EXPECT_TRUE(frustum.outside({{-1, -20, -1}, {1, -10, 1}}));
  EXPECT_TRUE(frustum.outside({{500, 10, -1}, {510, 12, 1}}));
  EXPECT_TRUE(frustum.outside({{-1, 10, 400}, {1, 12, 410}}));
  EXPECT_FALSE(frustum.outside({{-1, 10, -1}, {1, 12, 1}}));
  EXPECT_FALSE(frustum.outside({{-1, -1, -1}, {1, 1, 1}}));
  EXPECT_EQ(frustum.nearest_depth_m({{-1, -1, -1}, {1, 1, 1}}), 0);
}

}  // namespace
}  // namespace tintree::render
