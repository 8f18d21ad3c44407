// What every control does to the window: its own keys and mouse, under Xvfb.
#include <algorithm>

#include "tests/apps/view/xvfb_window.h"

namespace tintree::view {
namespace {

double ground_m(const glm::dvec3& p) { return test::AnalyticTree().height_m(p.x, p.y); }

/// The ground in a pixel of the picture, in steps of a metre.
glm::dvec3 ground_in(const render::Camera& camera, double x_px, double y_px) {
  const glm::dvec3 step = glm::normalize(camera.ray(x_px, y_px));
  glm::dvec3 p = camera.eye;
  for (int i = 0; i < 10000 && p.z > ground_m(p); ++i) p += step;
  return p;
}

const glm::dvec3 kFlightsEnd(640, -2000, 1400);

class WindowControls : public Window {
 protected:
  void drag(int button, int x_px, int y_px, int dx_px, int dy_px) const {
    point_at(x_px, y_px);
    xdotool({"mousedown", std::to_string(button)});
    point_at(x_px + dx_px / 2, y_px);
    point_at(x_px + dx_px, y_px + dy_px);
    xdotool({"mouseup", std::to_string(button)});
  }
  /// Plays a flight northward from the first view.
  void open_with_flight(int seconds) {
    const std::string file = dir_.file("way.json");
    const std::string from =
        R"({"keyframes": [{"seconds": 0, "eye_m": [640, -2400, 1400], "target_m": [640, -640, 0]})";
    const std::string to = R"(, "eye_m": [640, -2000, 1400], "target_m": [640, -640, 0]}]})";
    test::write_file(file, from + ", {\"seconds\": " + std::to_string(seconds) + to);
    view_ = std::make_unique<test::RunningProgram>("/usr/bin/env", view_arguments({"--flight", file, "--json", json_}));
    find_window();
  }
  /// Back to the first view, exactly.
  void go_home(const std::string& key) const {
    type(key);
    EXPECT_TRUE(wait_for([&] { return where().eye == kEye && where().target == kTarget; })) << key;
  }
};

TEST_F(WindowControls, KeysMoveWhereTheirRowsSay) {
  ASSERT_NO_FATAL_FAILURE(open());
  const glm::dvec3 east(1, 0, 0), north(0, 1, 0), up(0, 0, 1);
  const std::vector<std::pair<std::string, glm::dvec3>> moves{
      {"w", north},  {"s", -north},    {"a", -east},    {"d", east},     {"e", up},     {"q", -up},
      {"Up", north}, {"Down", -north}, {"Left", -east}, {"Right", east}, {"Prior", up}, {"Next", -up}};
  render::Camera before = where();
  for (const auto& [key, direction] : moves) {
    hold(key, 0.1);
    const render::Camera after = where();
    const glm::dvec3 moved = after.eye - before.eye;
    EXPECT_GT(glm::dot(moved, direction), 20) << key;
    EXPECT_NEAR(glm::length(moved), glm::dot(moved, direction), 1e-6) << key;
    EXPECT_NEAR(glm::distance(after.target - before.target, moved), 0, 1e-6) << key;
    before = after;
  }
  ASSERT_NO_FATAL_FAILURE(go_home("Home"));
  type("Tab");
  hold("w", 0.1);
  const glm::dvec3 ahead = where().eye - kEye;
  EXPECT_NEAR(glm::dot(glm::normalize(ahead), glm::normalize(kTarget - kEye)), 1, 1e-9) << "where it looks";
  drag(1, 240, 160, 60, 0);
  EXPECT_EQ(where().eye, kEye + ahead) << "in fly mode a drag turns the head";
  EXPECT_GT(std::abs((where().target - where().eye).x), 100);
  close();
}

TEST_F(WindowControls, TheSpeedIsTheHeightASecondAndFiveTimesThatWithShift) {
  ASSERT_NO_FATAL_FAILURE(open());
  // Slow frames make it slower, nothing makes it faster.
  const auto fastest = [&](const std::string& key) {
    double most = 0;
    const render::Flight flight = record([&] { hold(key, 0.6); });
    const auto& keys = flight.keyframes();
    for (std::size_t i = 1; i < keys.size(); ++i) {
      const double height_m = keys[i - 1].eye.z - ground_m(keys[i - 1].eye);
      const double speed = glm::distance(keys[i].eye, keys[i - 1].eye) / (keys[i].seconds - keys[i - 1].seconds);
      most = std::max(most, speed / height_m);
    }
    return most;
  };
  const double walk = fastest("d");
  EXPECT_GT(walk, 0.2);
  EXPECT_LT(walk, 1.3);
  xdotool({"keydown", "shift"});
  const double run = fastest("a");
  xdotool({"keyup", "shift"});
  EXPECT_GT(run, 1.5);
  EXPECT_LT(run, 6.5);
  close();
}

TEST_F(WindowControls, TheMouseMovesTheGroundAndTurnsTheHead) {
  ASSERT_NO_FATAL_FAILURE(open());
  for (const int button : {2, 3}) {
    const glm::dvec3 grabbed = ground_in(where(), 240, 170);
    drag(button, 240, 170, 60, 20);
    const render::Camera after = where();
    EXPECT_LT(glm::distance(ground_in(after, 300, 190), grabbed), 15) << button;
    EXPECT_EQ(after.eye.z, kEye.z);
    EXPECT_GT(glm::distance(after.eye, kEye), 50) << button;
    ASSERT_NO_FATAL_FAILURE(go_home("r"));
  }
  xdotool({"keydown", "shift"});
  drag(1, 240, 160, 60, 0);
  xdotool({"keyup", "shift"});
  const render::Camera looked = where();
  EXPECT_EQ(looked.eye, kEye);
  const glm::dvec3 ahead = glm::normalize(looked.target - looked.eye);
  EXPECT_NEAR(std::atan2(-ahead.x, ahead.y), 60 / looked.focal_px(), 1e-6);
  ASSERT_NO_FATAL_FAILURE(go_home("r"));

  const glm::dvec3 there = ground_in(where(), 330, 210);
  point_at(330, 210);
  type("c");
  EXPECT_TRUE(wait_for([&] { return glm::distance(where().target, there) < 15; }));
  EXPECT_EQ(where().eye, kEye);
  ASSERT_NO_FATAL_FAILURE(go_home("r"));
  // One click of each of two buttons is no double click.
  xdotool({"click", "3", "click", "1"});
  const render::Camera clicked = where();
  EXPECT_EQ(clicked.eye, kEye);
  EXPECT_NEAR(glm::dot(clicked.axes().forward, glm::normalize(kTarget - kEye)), 1, 1e-12);
  // Away from what is under the cursor, which stays there.
  const glm::dvec3 middle = ground_in(where(), 330, 210);
  xdotool({"click", "5"});
  const render::Camera away = where();
  EXPECT_NEAR(glm::distance(away.eye, middle), glm::distance(kEye, middle) / 0.85, 10);
  EXPECT_LT(glm::distance(ground_in(away, 330, 210), middle), 15);
  close();
}

TEST_F(WindowControls, ThePixelErrorAndTheSunChangeThePicture) {
  ASSERT_NO_FATAL_FAILURE(open());
  // By its levels' colours, what is drawn at 16 pixels is what a new window at 16 draws, and not what one at 1 does.
  type("2");
  for (int i = 0; i < 8; ++i) type("plus");
  const Pixels coarse = still({"--show", "levels", "--pixel-error", "16"});
  ASSERT_GT(difference(coarse, still({"--show", "levels"})), 5);
  EXPECT_TRUE(wait_for([&] { return difference(picture(), coarse) < 0.5; }));

  const Pixels lit = picture();
  for (const auto& [key, back] : std::vector<std::pair<std::string, std::string>>{{"l", "j"}, {"i", "k"}}) {
    hold(key, 0.4);
    const Pixels turned = picture();
    EXPECT_GT(difference(turned, lit), 1) << key;
    hold(back, 1.2);
    EXPECT_GT(difference(picture(), turned), 1) << back;
  }
  close();
}

TEST_F(WindowControls, ShowsFiguresThePlaceAndFrozenTiles) {
  ASSERT_NO_FATAL_FAILURE(open());
  point_at(200, 200);
  const Pixels here = figures();
  point_at(300, 250);
  Pixels there;
  EXPECT_TRUE(wait_for([&] {  // at rest no figure changes
    there = figures();
    return figures() == there;
  }));
  EXPECT_GT(difference(here, there), 0.2) << "the place under the cursor";
  type("t");
  EXPECT_TRUE(wait_for([&] { return difference(figures(), there) > 5; }));
  type("t");
  EXPECT_TRUE(wait_for([&] { return difference(figures(), there) < 3; }));

  // From above, the pyramid of the frozen view shows.
  const auto pyramid = [](const Pixels& p) {
    int count = 0;
    for (std::size_t i = 0; i + 2 < p.size(); i += 3) count += p[i] > 200 && p[i + 1] > 150 && p[i + 2] < 120;
    return count;
  };
  type("6");
  hold("s", 0.3);
  hold("e", 0.3);
  const int lines = pyramid(picture());
  EXPECT_GT(lines, 100);
  type("6");
  EXPECT_TRUE(wait_for([&] { return pyramid(picture()) < lines / 4; }));
  close();
}

TEST_F(WindowControls, AFlightIsDrawnWithoutRests) {
  ASSERT_NO_FATAL_FAILURE(open_with_flight(600));
  const Pixels begun = picture();
  EXPECT_TRUE(wait_for([&] { return picture() != begun; }));
  // One that slept between frames would sleep for as long as nobody touches it.
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const auto end = close();
  EXPECT_GT(end.at("frames").get<int>(), 1);
  EXPECT_EQ(end.at("rests"), 0);
}

TEST_F(WindowControls, AtTheEndOfAFlightTheWindowRests) {
  ASSERT_NO_FATAL_FAILURE(open_with_flight(1));
  const std::string png = dir_.file("end.png");
  std::vector<std::string> arguments = still_arguments(png, {});
  std::ranges::replace(arguments, "640,-2400,1400", "640,-2000,1400");
  EXPECT_EQ(test::run_program(TINTREE_VIEW, arguments).exit_code, 0);
  EXPECT_TRUE(wait_for([&] { return difference(picture(), read_pixels(png)) < 0.5; }));
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const auto end = close();
  EXPECT_EQ(point(end, "eye_m"), kFlightsEnd);
  EXPECT_GT(end.at("rests").get<int>(), 0);
}

TEST_F(WindowControls, AFlightIsStoppedAndPlayedAgain) {
  ASSERT_NO_FATAL_FAILURE(open_with_flight(600));
  type("p");
  const Pixels stopped = picture();
  EXPECT_EQ(picture(), stopped);
  type("p");
  const Pixels begun = picture();
  EXPECT_TRUE(wait_for([&] { return picture() != begun; }));
  type("p");
  const glm::dvec3 eye = where().eye;
  EXPECT_EQ(where().eye, eye);
  EXPECT_LT(eye.y, kFlightsEnd.y);
  EXPECT_GT(eye.y, kEye.y);
  close();
}

}  // namespace
}  // namespace tintree::view
