#include "render/impostor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "tests/render/analytic_tree.h"

namespace tintree::render {
namespace {

glm::dvec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

/// Where a point is in the picture, pixels; false for one that cannot be seen.
bool project(const Camera& camera, const glm::dvec3& at, glm::dvec2& out) {
  const CameraAxes axes = camera.axes();
  const glm::dvec3 way = at - camera.eye;
  const double depth = glm::dot(way, axes.forward);
  if (depth <= 0) return false;
  const glm::dvec2 place(glm::dot(way, axes.right) / depth, glm::dot(way, axes.up) / depth);
  out = place * camera.focal_px();
  return std::abs(place.x) <= camera.tan_half_x() && std::abs(place.y) <= camera.tan_half_y();
}

Camera random_camera(std::mt19937& random) {
  std::uniform_real_distribution<double> in(0, 1);
  Camera c;
  c.eye = 1000.0 * random_direction(random);
  c.target = c.eye + random_direction(random);
  c.fov_y_rad = 0.3 + 1.2 * in(random);
  c.width_px = 640 + static_cast<int>(1000 * in(random));
  return c;
}

// Points of the ground seen from a moved and turned eye, against where the picture's sphere shows them.
TEST(Impostor, NoPointIsShownFartherOffThanTheBound) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> in(0, 1);
  double closest = 0;
  int seen = 0;
  for (int i = 0; i < 3000; ++i) {
    const Camera view = random_camera(random);
    const double near_m = 100 * std::pow(100, in(random));
    const ImpostorView made{impostor_camera(view), near_m, near_m * (1 + 20 * in(random))};
    Camera now = view;
    now.eye += std::pow(in(random), 3) * 0.4 * near_m * random_direction(random);
    now.target = now.eye + (view.target - view.eye) + 0.2 * random_direction(random);
    const double bound = impostor_parallax_px(made, now);
    for (int k = 0; k < 30; ++k) {
      const glm::dvec3 ray = glm::normalize(view.ray(view.width_px * in(random), view.height_px * in(random)));
      const double t = k < 10   ? made.nearest_m
                       : k < 20 ? made.farthest_m
                                : std::lerp(made.nearest_m, made.farthest_m, in(random));
      glm::dvec2 real, shown;
      const bool real_in = project(now, made.camera.eye + t * ray, real);
      const bool shown_in = project(now, made.camera.eye + made.radius_m() * ray, shown);
      if (!real_in || !shown_in) continue;
      ++seen;
      EXPECT_LE(glm::length(real - shown), bound * (1 + 1e-9)) << i;
      closest = std::max(closest, glm::length(real - shown) / bound);
    }
  }
  EXPECT_GT(seen, 10000);
  EXPECT_GT(closest, 0.5) << "the bound is not needlessly large";
}

// What is in the view from the moved eye lies on the picture.
TEST(Impostor, TheWholeViewIsOnAPictureThatHolds) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> in(0, 1);
  int held = 0, gone = 0;
  for (int i = 0; i < 4000; ++i) {
    const Camera view = random_camera(random);
    const ImpostorView made{impostor_camera(view), 5000, 50000};
    Camera now = view;
    now.eye += 4 * in(random)*random_direction(random);
    now.target = now.eye + (view.target - view.eye) + 0.3 * in(random)*random_direction(random);
    if (!impostor_holds(made, now)) {
      ++gone;
      continue;
    }
    ++held;
    EXPECT_LE(impostor_parallax_px(made, now), impostor::kParallaxPx);
    for (int k = 0; k < 20; ++k) {
      const glm::dvec3 ray = glm::normalize(now.ray(now.width_px * in(random), now.height_px * in(random)));
      const double t = std::lerp(made.nearest_m, made.farthest_m, in(random));
      glm::dvec2 on_picture;
      EXPECT_TRUE(project(made.camera, now.eye + t * ray, on_picture)) << i;
    }
  }
  EXPECT_GT(held, 500);
  EXPECT_GT(gone, 500);
}

// It is drawn anew before its error reaches what is allowed, and holds as long as promised.
TEST(Impostor, HoldsForTheFramesThatItsDistanceIsChosenFor) {
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    const Camera view = random_camera(random);
    const double step_m = 3;
    const double begin_m = impostor_distance_m(step_m, view);
    const ImpostorView made{impostor_camera(view), begin_m, 1000 * begin_m};
    Camera now = view;
    const glm::dvec3 step = step_m * random_direction(random);
    for (int frame = 0; frame <= impostor::kFrames; ++frame) {
      EXPECT_TRUE(impostor_holds(made, now)) << frame;
      now.eye += step;
      now.target += step;
    }
    now.eye += 2.0 * impostor::kFrames * step;
    EXPECT_GT(impostor_parallax_px(made, now), impostor::kParallaxPx);
    EXPECT_FALSE(impostor_holds(made, now));
    Camera larger = view;
    larger.width_px *= 2;
    larger.height_px *= 2;
    EXPECT_FALSE(impostor_holds(made, larger)) << "its texels are too wide for a larger window";
  }
}

// Flown and turned frame by frame.
TEST(Impostor, FramesAreThoseForWhichItHolds) {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> in(0, 1);
  constexpr int kMost = 32;
  std::array<int, kMost + 1> seen{};
  for (int i = 0; i < 2000; ++i) {
    const Camera view = random_camera(random);
    const ImpostorView made{impostor_camera(view), 5000, 50000};
    Camera before = view;
    const glm::dvec3 step = 3 * std::pow(in(random), 2) * random_direction(random);
    const glm::dvec3 turn = step + 0.03 * std::pow(in(random), 2) * random_direction(random);
    Camera now = before;
    now.eye += step;
    now.target += turn;
    int frames = 0;
    for (Camera then = now; frames <= kMost && impostor_holds(made, then); ++frames) {
      then.eye += step;
      then.target += turn;
    }
    const int expected = std::max(frames - 1, 0);
    EXPECT_NEAR(impostor_frames(made, before, now, kMost), expected, 1) << i;
    ++seen[static_cast<std::size_t>(expected)];
  }
  EXPECT_GT(seen[0], 0);
  EXPECT_GT(seen[kMost / 2], 0);
  EXPECT_GT(seen[kMost], 0);
}

TEST(Impostor, DistancesToABoxAreThoseOfItsPoints) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> in(-1, 1);
  const cache::Box box{{-2, -1, 0}, {2, 1, 0.5}};
  for (int i = 0; i < 100; ++i) {
    const glm::dvec3 from(4 * in(random), 4 * in(random), 4 * in(random));
    double nearest = 1e9, farthest = 0;
    for (int k = 0; k < 21 * 21 * 21; ++k) {
      const glm::dvec3 at(-2 + 0.2 * (k % 21), -1 + 0.1 * (k / 21 % 21), 0.025 * (k / 441));
      nearest = std::min(nearest, glm::length(at - from));
      farthest = std::max(farthest, glm::length(at - from));
    }
    EXPECT_LE(nearest_m(box, from), nearest + 1e-9);
    EXPECT_GE(nearest_m(box, from), nearest - 0.2);
    EXPECT_NEAR(farthest_m(box, from), farthest, 1e-9);
  }
}

TEST(Impostor, ANodeIsCoveredByItselfItsAncestorsOrAllBelow) {
  const test::AnalyticTree tree;
  const cache::TileBounds bounds = tree.bounds();
  const std::array<const cache::TileBounds*, 1> trees{&bounds};
  const auto node = [&](const codec::TileId& id) { return static_cast<std::uint32_t>(bounds.find(id)); };
  TileSet set{{{1, 0, 0}, 0}, {{2, 2, 0}, 0}, {{2, 3, 0}, 0}, {{2, 2, 1}, 0}};
  EXPECT_TRUE(covered(set, trees, 0, node({1, 0, 0})));
  EXPECT_TRUE(covered(set, trees, 0, node({2, 1, 1})));
  EXPECT_FALSE(covered(set, trees, 0, node({2, 3, 1})));
  EXPECT_FALSE(covered(set, trees, 0, node({1, 1, 0})));
  EXPECT_FALSE(covered(set, trees, 0, node({0, 0, 0})));
  set.insert({{2, 3, 1}, 0});
  EXPECT_TRUE(covered(set, trees, 0, node({1, 1, 0})));
  set.insert({{{1, 0, 1}, 0}, {{1, 1, 1}, 0}});
  EXPECT_TRUE(covered(set, trees, 0, node({0, 0, 0})));
}

}  // namespace
}  // namespace tintree::render
