#include "apps/view/navigation.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace tintree::view {
namespace {

const NavigationLimits kLimits{1, 1e6};

render::Camera looking(const glm::dvec3& eye, const glm::dvec3& target) {
  render::Camera c;
  c.eye = eye;
  c.target = target;
  return c;
}

double reach(const render::Camera& c) { return glm::distance(c.eye, c.target); }

/// Where a place is seen, pixels from the left and the top.
glm::dvec2 seen_at(const render::Camera& c, const glm::dvec3& place) {
  const render::CameraAxes axes = c.axes();
  const glm::dvec3 q = place - c.eye;
  const double scale = c.focal_px() / glm::dot(q, axes.forward);
  return {0.5 * c.width_px + glm::dot(q, axes.right) * scale, 0.5 * c.height_px - glm::dot(q, axes.up) * scale};
}

TEST(Navigation, OrbitKeepsTargetAndDistance) {
  const render::Camera c = looking({1000, -4000, 3000}, {500, -500, 100});
  const render::Camera turned = orbit(c, 100, -40);
  EXPECT_EQ(turned.target, c.target);
  EXPECT_NEAR(reach(turned), reach(c), 1e-6);
  EXPECT_NEAR(glm::distance(orbit(c, 0, 0).eye, c.eye), 0, 1e-6);
  EXPECT_NEAR(glm::distance(orbit(turned, -100, 40).eye, c.eye), 0, 1e-6);
  // Half a turn for the picture's width.
  const render::Camera half = orbit(c, c.width_px, 0);
  EXPECT_NEAR(half.eye.x - c.target.x, c.target.x - c.eye.x, 1e-6);
  EXPECT_GT(orbit(c, 0, 1e6).axes().up.y, 0);  // Never over the top.
  EXPECT_GT(orbit(c, 0, -1e6).eye.z, c.target.z - 0.1 * reach(c));
}

TEST(Navigation, OrbitFromAViewUpwardDoesNotJump) {
  const render::Camera c = looking({0, 0, 0}, {0, 1000, 800});
  EXPECT_NEAR(glm::distance(orbit(c, 0, 0).eye, c.eye), 0, 1e-6);
}

TEST(Navigation, DraggingRightTurnsTheGroundRight) {
  const render::Camera c = looking({0, -1000, 500}, {0, 0, 0});
  const glm::dvec3 front(0, -100, 0);  // Between the eye and the target.
  EXPECT_GT(seen_at(orbit(c, 50, 0), front).x, seen_at(c, front).x);
}

TEST(Navigation, LookingRoundCarriesTheLandscapeWithTheMouse) {
  const render::Camera c = looking({0, -1000, 500}, {0, 0, 400});
  const render::Camera turned = look_round(c, 30, 20);
  EXPECT_EQ(turned.eye, c.eye);
  EXPECT_NEAR(reach(turned), reach(c), 1e-6);
  const glm::dvec2 moved = seen_at(turned, c.target) - seen_at(c, c.target);
  EXPECT_NEAR(moved.x, 30, 1);
  EXPECT_NEAR(moved.y, 20, 1);
  for (const double up : {-1e6, 1e6}) EXPECT_LT(std::abs(look_round(c, 0, up).axes().forward.z), 1);
}

TEST(Navigation, PanKeepsTheGrabbedPlaceUnderTheMouse) {
  const render::Camera c = looking({0, -1000, 500}, {100, 0, 0});
  const glm::dvec3 grabbed(-200, 150, 60);
  const render::Camera moved = pan(c, grabbed, 900, 500);
  EXPECT_NEAR(glm::distance(seen_at(moved, grabbed), {900, 500}), 0, 1e-6);
  EXPECT_EQ(moved.eye.z, c.eye.z);
  EXPECT_NEAR(glm::distance(moved.target - moved.eye, c.target - c.eye), 0, 1e-9);
  // Over the horizon there is nowhere to move it to.
  EXPECT_EQ(pan(looking({0, 0, 500}, {0, 1000, 400}), grabbed, 640, 0).eye, glm::dvec3(0, 0, 500));
}

TEST(Navigation, ZoomKeepsThePointUnderTheCursor) {
  const render::Camera c = looking({0, -1000, 500}, {0, 0, 0});
  const glm::dvec3 p = c.eye + c.ray(900, 500) * 800.0;
  const render::Camera nearer = zoom(c, p, 0.5, kLimits);
  EXPECT_NEAR(glm::distance(nearer.eye, p), 0.5 * glm::distance(c.eye, p), 1e-9);
  EXPECT_NEAR(glm::distance(seen_at(nearer, p), {900, 500}), 0, 1e-6);
  EXPECT_NEAR(glm::distance(nearer.axes().forward, c.axes().forward), 0, 1e-12);
  EXPECT_NEAR(reach(zoom(c, p, 1e-9, kLimits)), kLimits.nearest_m, 1e-6);
}

TEST(Navigation, MovesLevelOrAlongTheView) {
  const render::Camera c = looking({0, -1000, 500}, {0, 0, 0});
  const render::Camera level = move(c, {1, 0, 0}, 100, false);
  EXPECT_NEAR(glm::distance(level.eye, {0, -900, 500}), 0, 1e-9);
  EXPECT_NEAR(glm::distance(move(c, {0, 1, 0}, 100, false).eye, {100, -1000, 500}), 0, 1e-9);
  EXPECT_NEAR(glm::distance(move(c, {0, 0, -1}, 100, false).eye, {0, -1000, 400}), 0, 1e-9);
  const render::Camera along = move(c, {1, 0, 0}, 100, true);
  EXPECT_NEAR(glm::distance(glm::normalize(along.eye - c.eye), c.axes().forward), 0, 1e-12);
  EXPECT_NEAR(glm::distance(along.eye, c.eye), 100, 1e-9);
  // Straight down, ahead is still where the picture's upper edge points.
  const render::Camera down = looking({0, 0, 500}, {0, 0, 0});
  EXPECT_NEAR(glm::distance(move(down, {1, 0, 0}, 100, false).eye, {0, 100, 500}), 0, 1e-9);
}

TEST(Navigation, SpeedGrowsWithTheHeight) {
  EXPECT_DOUBLE_EQ(speed_m_per_s(2000, kLimits), 2 * speed_m_per_s(1000, kLimits));
  EXPECT_DOUBLE_EQ(speed_m_per_s(-5, kLimits), kLimits.nearest_m);
}

TEST(Navigation, GoesToAPointAndLooksAtIt) {
  const render::Camera c = looking({0, -1000, 500}, {0, 0, 0});
  const glm::dvec3 p(300, 200, 50);
  const render::Camera there = go_to(c, p, kLimits);
  EXPECT_NEAR(glm::distance(seen_at(there, p), {0.5 * c.width_px, 0.5 * c.height_px}), 0, 1e-6);
  EXPECT_NEAR(glm::distance(there.eye, p), glm::distance(c.eye, p) / 3, 1e-9);
  EXPECT_NEAR(glm::distance(there.axes().forward, c.axes().forward), 0, 1e-12);
  const render::Camera turned = look_at(c, p);
  EXPECT_EQ(turned.eye, c.eye);
  EXPECT_EQ(turned.target, p);
  EXPECT_EQ(look_at(c, c.eye).target, c.target);
}

TEST(Navigation, LiftsTheEyeOutOfTheGround) {
  const render::Camera c = looking({0, -1000, 500}, {0, 0, 0});
  EXPECT_EQ(keep_above(c, 400, true).eye, c.eye);
  EXPECT_EQ(keep_above(c, 700, false).eye.z, 700);
  EXPECT_EQ(keep_above(c, 700, false).target, c.target);
  EXPECT_EQ(keep_above(c, 700, true).target.z, 200);
}

TEST(Navigation, GlidesFromOneViewToAnother) {
  const render::Camera a = looking({0, -1000, 500}, {0, 0, 0});
  const render::Camera b = looking({4000, 3000, 90}, {4000, 2990, 85});
  EXPECT_NEAR(glm::distance(between(a, b, 0).eye, a.eye), 0, 1e-9);
  EXPECT_NEAR(glm::distance(between(a, b, 0).target, a.target), 0, 1e-6);
  EXPECT_NEAR(glm::distance(between(a, b, 1).eye, b.eye), 0, 1e-9);
  EXPECT_NEAR(glm::distance(between(a, b, 1).target, b.target), 0, 1e-6);
  glm::dvec3 before = a.eye;
  for (double t = 0.1; t <= 1; t += 0.1) {
    const render::Camera c = between(a, b, t);
    EXPECT_GT(glm::distance(c.eye, c.target), 1);
    EXPECT_LT(glm::distance(c.eye, b.eye), glm::distance(before, b.eye));
    before = c.eye;
  }
  // To look back there are two ways round; any will do as long as it is a view.
  const render::Camera back = looking(a.eye, a.eye - (a.target - a.eye));
  for (const double t : {0.3, 0.5, 0.7}) EXPECT_TRUE(std::isfinite(between(a, back, t).target.x));
}

TEST(Navigation, FindsAPlaceWhereNoGroundIs) {
  const render::Camera c = looking({0, -1000, 500}, {0, 0, 0});
  EXPECT_NEAR(point_on_level(c, 300, 600).z, 0, 1e-9);
  const render::Camera level = looking({0, -1000, 500}, {0, 0, 500});
  EXPECT_EQ(point_on_level(level, 640, 100), level.target);
}

}  // namespace
}  // namespace tintree::view
