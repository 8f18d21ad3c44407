#include "tests/apps/view/xvfb_window.h"

#include <algorithm>
#include <optional>

#include "cache/tile_store.h"

namespace tintree::view {
namespace {

TEST_F(Window, ShowsWhatKeysAskFor) {
  ASSERT_NO_FATAL_FAILURE(open());
  const Pixels plain = picture();
  type("2");
  const Pixels levels = picture();
  EXPECT_GT(difference(levels, plain), 5);
  EXPECT_LT(difference(levels, still({"--show", "levels"})), 0.5);
  type("3");
  EXPECT_LT(difference(picture(), still({"--show", "error"})), 0.5);
  type("1");
  type("f");
  EXPECT_LT(difference(picture(), still({"--show", "triangles"})), 0.5);
  type("f");
  type("5");
  EXPECT_LT(difference(picture(), still({"--show", "boxes"})), 0.5);
  type("5");
  EXPECT_LT(difference(picture(), plain), 0.5);

  const Pixels figures = picture("shift+F12");
  EXPECT_GT(difference(figures, plain), 1) << "figures along the lower edge";
  type("h");
  EXPECT_GT(difference(picture("shift+F12"), figures), 10) << "the help";
  EXPECT_LT(difference(picture(), plain), 0.5) << "a picture without text";

  type("plus");
  type("plus");
  type("minus");
  const auto end = close();
  EXPECT_NEAR(end.at("pixel_error").get<double>(), std::sqrt(2.0), 1e-9);
  EXPECT_EQ(point(end, "eye_m"), kEye);
  EXPECT_EQ(point(end, "target_m"), kTarget);
}

TEST_F(Window, FollowsTheMouse) {
  ASSERT_NO_FATAL_FAILURE(open());
  // An eighth of the width to the right is an eighth of half a turn.
  point_at(200, 160);
  xdotool({"mousedown", "1"});
  point_at(230, 160);
  point_at(260, 160);
  xdotool({"mouseup", "1"});
  auto end = close();
  glm::dvec3 away = point(end, "eye_m") - point(end, "target_m");
  const glm::dvec3 before = kEye - kTarget;
  EXPECT_NEAR(std::atan2(away.x, -away.y), -std::acos(-1.0) / 8, 1e-6);
  EXPECT_NEAR(away.z / glm::length(away), before.z / glm::length(before), 1e-6);
  EXPECT_NEAR(point(end, "target_m").z, test::AnalyticTree().height_m(640, point(end, "target_m").y), 10);

  pictures_ = 0;
  for (const auto& file : std::filesystem::directory_iterator(dir_.path()))
    if (file.path().filename().string().starts_with("tintree-")) std::filesystem::remove(file.path());
  ASSERT_NO_FATAL_FAILURE(open());
  // The wheel goes towards what is under the cursor, a double click to a third of the way from it.
  point_at(330, 200);
  xdotool({"click", "4", "click", "4"});
  xdotool({"click", "--repeat", "2", "--delay", "50", "1"});
  come_to_rest();
  end = close();
  const glm::dvec3 target = point(end, "target_m");
  away = point(end, "eye_m") - target;
  render::Camera camera;
  camera.eye = kEye;
  camera.target = kTarget;
  camera.width_px = kWidth;
  camera.height_px = kHeight;
  const glm::dvec3 ray = glm::normalize(camera.ray(330, 200));
  EXPECT_NEAR(glm::length(glm::cross(glm::normalize(target - kEye), ray)), 0, 1e-3) << "the place under the cursor";
  EXPECT_NEAR(target.z, test::AnalyticTree().height_m(target.x, target.y), 10);
  EXPECT_NEAR(glm::length(away), glm::distance(kEye, target) * 0.85 * 0.85 / 3, 2);
}

TEST_F(Window, FliesRecordsAndChangesItsSize) {
  ASSERT_NO_FATAL_FAILURE(open());
  type("F9");
  hold("w", 0.4);
  hold("Right", 0.3);
  type("F9");
  const std::string file = dir_.file("tintree-flight-001.json");
  ASSERT_TRUE(wait_for([&] { return std::filesystem::exists(file); }));
  const auto flight = render::Flight::load(file);
  ASSERT_TRUE(flight) << flight.error().text();
  EXPECT_EQ(flight->keyframes().front().eye, kEye);
  const glm::dvec3 last = flight->keyframes().back().eye;
  EXPECT_GT(last.y, kEye.y + 50);
  EXPECT_GT(last.x, kEye.x + 50);
  EXPECT_EQ(last.z, kEye.z);

  xdotool({"windowunmap", window_, "sleep", "0.2", "windowmap", window_});
  xdotool({"windowsize", window_, "300", "200"});
  ASSERT_NO_FATAL_FAILURE(focus());
  ASSERT_TRUE(wait_for([&] { return picture().size() == std::size_t{300} * 200 * 3; }));
  // Played, it ends where it did when it was recorded.
  type("p");
  picture();  // Taken after the key has been.
  std::this_thread::sleep_for(std::chrono::duration<double>(flight->end_s() - flight->begin_s() + 0.5));
  const auto end = close();
  EXPECT_EQ(end.at("width_px"), 300);
  EXPECT_EQ(end.at("height_px"), 200);
  EXPECT_NEAR(glm::distance(point(end, "eye_m"), last), 0, 1e-6);
}

// From a single pixel to more than the driver draws, where the picture keeps its size, which is said once.
TEST_F(Window, GoesOnAtAnySize) {
  ASSERT_NO_FATAL_FAILURE(open());
  const auto resize = [&](const std::string& width, const std::string& height) {
    xdotool({"windowsize", window_, width, height, "sleep", "0.2"});
    ASSERT_NO_FATAL_FAILURE(focus());
  };
  ASSERT_NO_FATAL_FAILURE(resize("1", "1"));
  EXPECT_TRUE(wait_for([&] { return picture().size() == 3; }));
  ASSERT_NO_FATAL_FAILURE(resize("300", "200"));
  EXPECT_TRUE(wait_for([&] { return picture().size() == std::size_t{300} * 200 * 3; }));
  ASSERT_NO_FATAL_FAILURE(resize("17000", "20"));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(picture().size(), std::size_t{300} * 200 * 3);
  type("Escape");
  const auto r = view_->wait();
  EXPECT_EQ(r.exit_code, 0) << r.all();
  EXPECT_NE(r.err.find("17000x20"), std::string::npos) << r.err;
  EXPECT_EQ(std::ranges::count(r.err, '\n'), 1) << r.err;
}

TEST_F(Window, NeedsOpenGl33) {
  std::vector<std::string> arguments = view_arguments({});
  arguments.insert(std::ranges::find(arguments, display_), "MESA_GL_VERSION_OVERRIDE=2.1");
  const auto r = test::run_program("/usr/bin/env", arguments);
  EXPECT_EQ(r.exit_code, 4) << r.all();
  EXPECT_NE(r.err.find("OpenGL 3.3"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("--headless osmesa"), std::string::npos) << r.err;
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
}

TEST_F(Window, RefusesANonsenseFlightBeforeItOpens) {
  const std::string flight = dir_.file("flight.json");
  test::write_file(flight, "{\"keyframes\": 7}");
  const auto r = test::run_program("/usr/bin/env", view_arguments({"--flight", flight}));
  EXPECT_EQ(r.exit_code, 3) << r.all();
  EXPECT_NE(r.err.find("flight.json"), std::string::npos) << r.err;
}

// A damaged tile is drawn from its parent and named once; the window goes on.
TEST_F(Window, GoesOnWithoutADamagedTile) {
  std::string bytes = test::read_file(tree_);
  const auto payload = cache::TileStore::open(tree_)->read({2, 1, 1})->payload;
  const std::size_t at = bytes.find(std::string(reinterpret_cast<const char*>(payload.data()), 40));
  ASSERT_NE(at, std::string::npos);
  bytes[at + 30] = static_cast<char>(bytes[at + 30] ^ 4);
  test::write_file(tree_, bytes);
  std::vector<std::string> arguments = view_arguments({"--pixel-error", "0", "--json", json_});
  const std::string errors = dir_.file("errors");
  arguments.insert(arguments.begin(), {"-c", "exec /usr/bin/env \"$@\" 2> '" + errors + "'", "sh"});
  view_ = std::make_unique<test::RunningProgram>("/bin/sh", arguments);
  ASSERT_NO_FATAL_FAILURE(find_window());
  ASSERT_TRUE(wait_for([&] { return test::read_file(errors).ends_with('\n'); }));
  hold("d", 0.3);
  come_to_rest();
  type("Escape");
  EXPECT_EQ(view_->wait().exit_code, 0);
  const std::string message = test::read_file(errors);
  EXPECT_NE(message.find("is damaged"), std::string::npos) << message;
  EXPECT_EQ(std::ranges::count(message, '\n'), 1) << message;
  EXPECT_EQ(nlohmann::json::parse(test::read_file(json_)).at("tile_errors"), 1);
}

}  // namespace
}  // namespace tintree::view
