#include "apps/view/pilot.h"

#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace tintree::view {
namespace {

/// Hills that rise and fall by 100 m, on the square |x|, |y| < 5000.
double hill(double x, double y) { return 100 * std::sin(x / 300) * std::cos(y / 200); }
bool on_ground(double x, double y) { return std::abs(x) < 5000 && std::abs(y) < 5000; }
constexpr double kClearance = 2;

GroundSense hills() {
  GroundSense out;
  out.floor_m = [](double x, double y) -> std::optional<double> {
    if (!on_ground(x, y)) return std::nullopt;
    return hill(x, y) + kClearance;
  };
  out.pick = [](const render::Ray& ray) -> std::optional<glm::dvec3> {
    const glm::dvec3 step = glm::normalize(ray.direction);
    for (double t = 0; t < 20000; t += 1) {
      const glm::dvec3 p = ray.origin + t * step;
      if (on_ground(p.x, p.y) && p.z <= hill(p.x, p.y)) return p;
    }
    return std::nullopt;
  };
  return out;
}

render::Camera home() {
  render::Camera c;
  c.eye = {0, -2000, 1000};
  c.target = {0, 0, 0};
  return c;
}

Pilot pilot() { return {home(), {10, 50000}, hills()}; }

void finish(Pilot& p) {
  for (int i = 0; i < 200 && p.advance(0.05, {}, false); ++i) {
  }
}

TEST(Pilot, NeverGoesUnderground) {
  std::mt19937 random(3);
  const auto in = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  Pilot p = pilot();
  int low = 0;
  for (int i = 0; i < 600; ++i) {
    const double x = in(0, 1280);
    const double y = in(0, 720);
    switch (random() % 6) {
      case 0:
        p.advance(0.1, {in(-1, 1), in(-1, 1), in(-1, 0.2)}, random() % 2 == 0);
        break;
      case 1:
        p.zoom_by(in(-2, 5), x, y);
        break;
      case 2:
        p.begin_drag(Pilot::Drag::kOrbit, x, y);
        p.drag_to(x + in(-300, 300), y + in(-300, 300));
        p.end_drag();
        break;
      case 3:
        p.begin_drag(Pilot::Drag::kPan, x, y);
        p.drag_to(x + in(-100, 100), y + in(-100, 100));
        p.end_drag();
        break;
      case 4:
        p.begin_drag(Pilot::Drag::kLook, x, y);
        p.drag_to(x + in(-300, 300), y + in(-100, 100));
        p.end_drag();
        break;
      default:
        p.go_there(x, y);
        p.advance(0.3, {}, false);
    }
    const glm::dvec3 eye = p.camera().eye;
    ASSERT_TRUE(std::isfinite(eye.x + eye.y + eye.z));
    ASSERT_GT(glm::distance(eye, p.camera().target), 1e-6);
    ASSERT_TRUE(!on_ground(eye.x, eye.y) || eye.z >= hill(eye.x, eye.y) + kClearance - 1e-6);
    if (on_ground(eye.x, eye.y) && eye.z < hill(eye.x, eye.y) + 3 * kClearance) ++low;
    if (!on_ground(eye.x, eye.y) || eye.z > 3000) p.take(home());
  }
  EXPECT_GT(low, 20) << "the test has to come near the ground";
}

TEST(Pilot, DoubleClickGoesThereAndHomeComesBack) {
  Pilot p = pilot();
  const auto point = p.ground_under(800, 500);
  ASSERT_TRUE(point);
  p.go_there(800, 500);
  EXPECT_TRUE(p.advance(0.1, {}, false));
  EXPECT_NE(p.camera().eye, home().eye);
  finish(p);
  EXPECT_EQ(p.camera().target, *point);
  EXPECT_NEAR(glm::distance(p.camera().eye, *point), glm::distance(home().eye, *point) / 3, 1);
  p.go_home();
  finish(p);
  EXPECT_EQ(p.camera().eye, home().eye);
  EXPECT_EQ(p.camera().target, home().target);
  EXPECT_FALSE(p.advance(0.1, {}, false));
}

TEST(Pilot, LooksAtThePlaceUnderTheCursor) {
  Pilot p = pilot();
  const auto point = p.ground_under(300, 600);
  ASSERT_TRUE(point);
  p.look_there(300, 600);
  finish(p);
  EXPECT_EQ(p.camera().eye, home().eye);
  EXPECT_EQ(p.camera().target, *point);
}

TEST(Pilot, FliesFasterFromHigherUp) {
  const auto metres = [](double height, bool fast) {
    render::Camera c = home();
    c.eye.z = height;
    Pilot p(c, {10, 50000}, hills());
    p.advance(0.1, {1, 0, 0}, fast);
    return glm::distance(p.camera().eye, c.eye);
  };
  EXPECT_NEAR(metres(4000, false) / metres(1000, false), 4, 0.5);
  EXPECT_NEAR(metres(1000, true) / metres(1000, false), 5, 1e-6);
}

TEST(Pilot, FlyModeGoesWhereItLooks) {
  Pilot p = pilot();
  p.advance(0.1, {1, 0, 0}, false);
  EXPECT_EQ(p.camera().eye.z, home().eye.z);
  p.toggle_fly_mode();
  p.advance(0.1, {1, 0, 0}, false);
  EXPECT_LT(p.camera().eye.z, home().eye.z);
  // And a drag turns the head.
  const glm::dvec3 eye = p.camera().eye;
  p.begin_drag(Pilot::Drag::kOrbit, 600, 300);
  p.drag_to(700, 320);
  EXPECT_EQ(p.camera().eye, eye);
}

TEST(Pilot, KeysTakeOverFromAGlide) {
  Pilot p = pilot();
  p.go_home();
  p.go_there(800, 500);
  p.advance(0.1, {0, 1, 0}, false);
  EXPECT_FALSE(p.advance(0.1, {}, false));
}

TEST(Pilot, KeepsItsViewWhenTheWindowChangesSize) {
  Pilot p = pilot();
  p.go_there(800, 500);
  p.resize(300, 900);
  finish(p);
  EXPECT_EQ(p.camera().width_px, 300);
  EXPECT_EQ(p.camera().height_px, 900);
}

}  // namespace
}  // namespace tintree::view
