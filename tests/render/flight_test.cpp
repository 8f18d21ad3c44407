#include "render/flight.h"

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

Flight flight(std::vector<Keyframe> keys) { return *Flight::create(std::move(keys)); }

TEST(Flight, PassesThroughItsKeyframesAndStandsStillOutsideThem) {
  const Flight f = flight({{1, {0, 0, 10}, {5, 5, 0}}, {2, {10, 3, 20}, {9, 9, 0}}, {5, {11, 30, 5}, {40, 1, 0}}});
  for (const Keyframe& k : f.keyframes()) {
    const Camera c = f.at(k.seconds, 640, 480);
    EXPECT_NEAR(glm::distance(c.eye, k.eye), 0, 1e-9);
    EXPECT_NEAR(glm::distance(c.target, k.target), 0, 1e-9);
    EXPECT_EQ(c.width_px, 640);
  }
  EXPECT_EQ(f.at(-10, 1, 1).eye, f.at(1, 1, 1).eye);
  EXPECT_EQ(f.at(99, 1, 1).target, f.at(5, 1, 1).target);
}

// On a parabola in time the curve is that parabola wherever both ends of a piece have neighbours.
TEST(Flight, FollowsAParabola) {
  const auto at = [](double t) { return glm::dvec3(3 * t * t - t, 100 - 7 * t, 0.5 * t * t + 2); };
  std::vector<Keyframe> keys;
  for (const double t : {0.0, 1.0, 1.5, 4.0, 4.5}) keys.push_back({t, at(t), at(t) + glm::dvec3(0, 9, -1)});
  const Flight f = flight(keys);
  for (double t = 1; t <= 4; t += 0.125) {
    EXPECT_NEAR(glm::distance(f.at(t, 1, 1).eye, at(t)), 0, 1e-9) << t;
    EXPECT_NEAR(glm::distance(f.at(t, 1, 1).target - f.at(t, 1, 1).eye, glm::dvec3(0, 9, -1)), 0, 1e-9);
  }
}

TEST(Flight, NothingJerks) {
  const Flight f = flight({{0, {0, 0, 9}, {9, 9, 0}},
                           {2, {80, 3, 20}, {9, 9, 0}},
                           {2.5, {11, 30, 5}, {40, 1, 0}},
                           {9, {-50, 0, 50}, {0, 0, 0}}});
  constexpr double kStep = 1e-5;
  for (const double t : {2.0, 2.5}) {
    const glm::dvec3 here = f.at(t, 1, 1).eye;
    const glm::dvec3 before = (here - f.at(t - kStep, 1, 1).eye) / kStep;
    const glm::dvec3 after = (f.at(t + kStep, 1, 1).eye - here) / kStep;
    EXPECT_NEAR(glm::distance(before, after), 0, 1e-2) << t;
  }
}

TEST(Flight, ReadsTargetsAndAngles) {
  const auto f = Flight::from_json(R"({"fov_y_deg": 60, "keyframes": [
      {"seconds": 0, "eye_m": [1, 2, 3], "target_m": [4, 5, 6]},
      {"seconds": 1.5, "eye_m": [1e6, -2, 300], "azimuth_deg": 90, "elevation_deg": -30}]})",
                                   "f.json");
  ASSERT_TRUE(f) << f.error().text();
  EXPECT_NEAR(f->fov_y_rad(), std::acos(-1) / 3, 1e-12);
  EXPECT_EQ(f->keyframes()[0].target, glm::dvec3(4, 5, 6));
  const Camera c = f->at(1.5, 8, 8);
  EXPECT_NEAR(glm::distance(c.axes().forward, glm::dvec3(std::sqrt(0.75), 0, -0.5)), 0, 1e-9);
}

TEST(Flight, ComesBackFromItsOwnJson) {
  const Flight f = flight({{0.1, {1.0 / 3, -2e6, 3}, {4, 5, 6}}, {7, {1, 2, 3}, {4, 5, 6.7}}});
  const auto again = Flight::from_json(f.to_json(), "");
  ASSERT_TRUE(again) << again.error().text();
  for (const double t : {0.1, 1.0, 3.3, 7.0}) {
    EXPECT_EQ(again->at(t, 3, 2).eye, f.at(t, 3, 2).eye);
    EXPECT_EQ(again->at(t, 3, 2).target, f.at(t, 3, 2).target);
  }
  EXPECT_NEAR(again->fov_y_rad(), f.fov_y_rad(), 1e-12);
}

// However unevenly its keyframes lie, the camera stays where numbers have a meaning.
TEST(Flight, StaysInBounds) {
  const double far = 1e12;
  const double apart = Flight::kLeastApart_s;
  const Flight f = flight({{0, {-far, far, far}, {0, 0, 0}},
                           {apart, {far, -far, -far}, {0, 0, 0}},
                           {Flight::kLongest_s, {-far, far, far}, {0, 0, 0}}});
  for (double t = 0; t <= 1; t += 0.01) {
    const glm::dvec3 eye = f.at(t * Flight::kLongest_s, 8, 8).eye;
    EXPECT_LE(glm::length(eye), 1e23);
  }
  EXPECT_TRUE(Flight::create({{1e9, {0, 0, 1}, {1, 1, 0}}, {1e9 + apart, {0, 0, 1}, {1, 1, 0}}}))
      << "a clock's seconds";
}

TEST(Flight, SaysWhatIsWrong) {
  const std::string a = R"({"seconds": 0, "eye_m": [0, 0, 1], "target_m": [1, 1, 0]})";
  const auto two = [&](const std::string& b) { return R"({"keyframes": [)" + a + "," + b + "]}"; };
  for (const auto& [text, about] : std::vector<std::pair<std::string, std::string>>{
           {"", "no JSON"},
           {"{]", "no JSON"},
           {"[1, 2]", "braces"},
           {"{}", "keyframes"},
           {R"({"keyframes": []})", "two keyframes"},
           {R"({"keyframes": [)" + a + "]}", "two keyframes"},
           {R"({"keyframes": 7})", "keyframes"},
           {R"({"speed": 7, "keyframes": []})", "speed"},
           {R"({"fov_y_deg": 0, "keyframes": [)" + a + "," + a + "]}", "fov_y_deg"},
           {two("3"), "keyframe 2"},
           {two(a), "keyframe 2: \"seconds\""},
           {two(R"({"seconds": -1, "eye_m": [0, 0, 1], "target_m": [1, 1, 0]})"), "keyframe 2: \"seconds\""},
           {two(R"({"seconds": 1e-300, "eye_m": [0, 0, 1], "target_m": [1, 1, 0]})"), "millisecond"},
           {two(R"({"seconds": 1e15, "eye_m": [0, 0, 1], "target_m": [1, 1, 0]})"), "keyframe 2: \"seconds\""},
           {two(R"({"seconds": 1e308, "eye_m": [0, 0, 1], "target_m": [1, 1, 0]})"), "keyframe 2: \"seconds\""},
           {R"({"keyframes": [{"seconds": -1e308, "eye_m": [0, 0, 1], "target_m": [1, 1, 0]}, )" + a + "]}",
            "keyframe 1"},
           {two(R"({"seconds": "x", "eye_m": [0, 0, 1], "target_m": [1, 1, 0]})"), "keyframe 2: \"seconds\""},
           {two(R"({"seconds": 1, "eye_m": [0, 0], "target_m": [1, 1, 0]})"), "eye_m"},
           {two(R"({"seconds": 1, "eye_m": [0, 0, null], "target_m": [1, 1, 0]})"), "eye_m"},
           {two(R"({"seconds": 1, "eye_m": [0, 0, 1]})"), "target_m"},
           {two(R"({"seconds": 1, "eye_m": [0, 0, 1], "azimuth_deg": 1})"), "elevation_deg"},
           {two(R"({"seconds": 1, "eye_m": [0, 0, 1], "target_m": [1, 1, 0], "azimuth_deg": 1})"), "leave one"},
           {two(R"({"seconds": 1, "eye_m": [0, 0, 1], "target_m": [0, 0, 1]})"), "keyframe 2: the eye"},
           {two(R"({"seconds": 1, "eye_m": [0, 0, 1e300], "target_m": [0, 0, 1]})"), "keyframe 2"},
           {two(R"({"seconds": 1, "eye": [0, 0, 1], "target_m": [0, 0, 1]})"), "\"eye\" is unknown"}}) {
    const auto f = Flight::from_json(text, "my.json");
    ASSERT_FALSE(f) << text;
    EXPECT_EQ(f.error().code, ErrorCode::kBadData) << text;
    EXPECT_EQ(f.error().where, "my.json");
    EXPECT_NE(f.error().message.find(about), std::string::npos) << f.error().text();
  }
  EXPECT_FALSE(Flight::create({{0, {0, 0, 0}, {1, 0, 0}}, {std::nan(""), {0, 0, 0}, {1, 0, 0}}}));
  const test::TempDir dir;
  EXPECT_EQ(Flight::load(dir.file("none.json")).error().code, ErrorCode::kIo);
  EXPECT_EQ(Flight::load(dir.path()).error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace tintree::render
