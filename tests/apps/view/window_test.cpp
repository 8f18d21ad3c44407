// The window under Xvfb, with the keys and the mouse of xdotool.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <OpenImageIO/imageio.h>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "render/flight.h"
#include "tests/render/analytic_tree.h"
#include "tests/support/run_program.h"
#include "tests/support/temp_dir.h"

namespace tintree::view {
namespace {

constexpr int kWidth = 480;
constexpr int kHeight = 320;
const glm::dvec3 kEye(640, -2400, 1400);
const glm::dvec3 kTarget(640, -640, 0);

bool wait_for(const std::function<bool()>& done, double seconds = 30) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

using Pixels = std::vector<std::uint8_t>;

Pixels read_pixels(const std::string& path) {
  const auto in = OIIO::ImageInput::open(path);
  if (!in) return {};
  const auto& spec = in->spec();
  Pixels out(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
             static_cast<std::size_t>(spec.nchannels));
  return in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, out.data()) ? out : Pixels{};
}

/// Mean difference of two pictures' values, 0 to 255.
double difference(const Pixels& a, const Pixels& b) {
  if (a.size() != b.size() || a.empty()) return 255;
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(static_cast<double>(a[i]) - b[i]);
  return sum / static_cast<double>(a.size());
}

class Window : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* program : {"/usr/bin/Xvfb", "/usr/bin/xdotool"}) {
      if (!std::filesystem::exists(program)) GTEST_SKIP() << program << " is missing; scripts/setup installs it";
    }
    test::AnalyticTree().write(tree_);
    // Tests that run side by side take different displays; a number that is in use fails, and the next one is tried.
    const int first = 100 + static_cast<int>(::getpid() % 20000);
    for (int number = first; number < first + 5 && display_.empty(); ++number) start_display(number);
    ASSERT_NE(display_, "") << "Xvfb does not start";
  }

  void start_display(int number) {
    const std::string ready = dir_.file("display");
    const std::string name = ":" + std::to_string(number);
    xvfb_ = std::make_unique<test::RunningProgram>(
        "/bin/sh", std::vector<std::string>{"-c", "exec /usr/bin/Xvfb " + name +
                                                      " -displayfd 3 -noreset -screen 0 640x480x24 -nolisten tcp 3> '" +
                                                      ready + "'"});
    wait_for([&] { return test::read_file(ready).ends_with('\n') || !xvfb_->running(); });
    if (xvfb_->running()) display_ = "DISPLAY=" + name;
  }

  std::vector<std::string> view_arguments(const std::vector<std::string>& more) const {
    std::vector<std::string> out{
        "-C",         dir_.path(), "-u",     "WAYLAND_DISPLAY", display_, "LIBGL_ALWAYS_SOFTWARE=1",
        TINTREE_VIEW, tree_,       "--size", "480x320",         "--eye",  "640,-2400,1400",
        "--target",   "640,-640,0"};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }

  /// Opens the window and waits until it can be typed into.
  void open(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = view_arguments(more);
    arguments.insert(arguments.end(), {"--json", json_});
    view_ = std::make_unique<test::RunningProgram>("/usr/bin/env", arguments);
    ASSERT_NO_FATAL_FAILURE(find_window());
    // With its tiles on the screen: the picture of a run without a window.
    const std::string still = dir_.file("still.png");
    const auto r = test::run_program(TINTREE_VIEW, still_arguments(still, {}));
    ASSERT_EQ(r.exit_code, 0) << r.all();
    ASSERT_TRUE(wait_for([&] { return difference(read_pixels(still), picture()) < 0.5; }));
  }

  std::vector<std::string> still_arguments(const std::string& png, const std::vector<std::string>& more) const {
    std::vector<std::string> out{tree_,   "--headless",     "osmesa",   "--size",     "480x320",
                                 "--eye", "640,-2400,1400", "--target", "640,-640,0", "--screenshot",
                                 png,     "--quiet"};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }

  Pixels still(const std::vector<std::string>& more) const {
    const std::string png = dir_.file("other.png");
    const auto r = test::run_program(TINTREE_VIEW, still_arguments(png, more));
    EXPECT_EQ(r.exit_code, 0) << r.all();
    return read_pixels(png);
  }

  test::ProgramResult xdotool(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {display_, "/usr/bin/xdotool"});
    return test::run_program("/usr/bin/env", arguments);
  }
  /// Waits for the window and gives it the keys.
  void find_window() {
    ASSERT_TRUE(wait_for([&] {
      window_ = xdotool({"search", "--onlyvisible", "--name", "small.tintree"}).out;
      return !window_.empty() || !view_->running();
    }));
    ASSERT_TRUE(view_->running()) << view_->wait().all() << test::read_file(dir_.file("errors"));
    window_.pop_back();
    ASSERT_NO_FATAL_FAILURE(focus());
  }
  void focus() const {
    ASSERT_TRUE(wait_for([&] {
      xdotool({"windowfocus", window_});
      return xdotool({"getwindowfocus"}).out == window_ + "\n";
    }));
  }
  void type(const std::string& key) const { xdotool({"key", key}); }
  void hold(const std::string& key, double seconds) const {
    xdotool({"keydown", key, "sleep", std::to_string(seconds), "keyup", key});
  }
  void point_at(int x, int y) const {
    xdotool({"mousemove", "--window", window_, std::to_string(x), std::to_string(y)});
  }

  /// Presses the key for a picture and reads the file.
  Pixels picture(const std::string& key = "F12") {
    char name[32];
    std::snprintf(name, sizeof name, "tintree-%03d.png", ++pictures_);
    type(key);
    const std::string path = dir_.file(name);
    if (!wait_for([&] { return std::filesystem::exists(path) || !view_->running(); })) return {};
    return read_pixels(path);
  }

  /// Waits until the picture stays.
  void come_to_rest() {
    Pixels last;
    EXPECT_TRUE(wait_for([&] {
      const Pixels before = std::exchange(last, picture());
      return last == before;
    }));
  }

  /// Ends by the key and reads where the camera was.
  nlohmann::json close() {
    type("Escape");
    const auto r = view_->wait();
    EXPECT_EQ(r.exit_code, 0) << r.all();
    EXPECT_EQ(r.err, "");
    return nlohmann::json::parse(test::read_file(json_));
  }
  static glm::dvec3 point(const nlohmann::json& figures, const char* key) {
    return {figures.at(key)[0].get<double>(), figures.at(key)[1].get<double>(), figures.at(key)[2].get<double>()};
  }

  test::TempDir dir_;
  std::string tree_ = dir_.file("small.tintree");
  std::string json_ = dir_.file("session.json");
  std::string display_;
  std::unique_ptr<test::RunningProgram> xvfb_;
  std::unique_ptr<test::RunningProgram> view_;
  std::string window_;
  int pictures_ = 0;
};

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
