#pragma once

/// The window under Xvfb, with the keys and the mouse of xdotool.

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
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

inline constexpr int kWidth = 480;
inline constexpr int kHeight = 320;
inline const glm::dvec3 kEye(640, -2400, 1400);
inline const glm::dvec3 kTarget(640, -640, 0);

inline bool wait_for(const std::function<bool()>& done, double seconds = 30) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

using Pixels = std::vector<std::uint8_t>;

inline Pixels read_pixels(const std::string& path) {
  const auto in = OIIO::ImageInput::open(path);
  if (!in) return {};
  const auto& spec = in->spec();
  Pixels out(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
             static_cast<std::size_t>(spec.nchannels));
  return in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, out.data()) ? out : Pixels{};
}

/// Mean difference of two pictures' values, 0 to 255.
inline double difference(const Pixels& a, const Pixels& b) {
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

  /// The rows of a picture with its text that the figures are in.
  Pixels figures() {
    const Pixels all = picture("shift+F12");
    constexpr std::ptrdiff_t kRows = 50;
    return all.size() < std::size_t{kWidth} * kHeight * 3 ? Pixels{}
                                                          : Pixels(all.end() - kRows * kWidth * 3, all.end());
  }

  /// What is recorded from now to when `act` is done.
  render::Flight record(const std::function<void()>& act) const {
    const std::string path = dir_.file("tintree-flight-001.json");
    for (double pause_s = 0.05;; pause_s *= 4) {
      type("F9");
      act();
      std::this_thread::sleep_for(std::chrono::duration<double>(pause_s));
      type("F9");
      // One that took no time, because the machine was busy, is not saved.
      if (wait_for([&] { return std::filesystem::exists(path); }, 5) || pause_s > 1) break;
    }
    auto flight = render::Flight::load(path);
    std::filesystem::remove(path);
    EXPECT_TRUE(flight) << flight.error().text();
    return flight.value();
  }
  /// Where the camera is.
  render::Camera where() const {
    const render::Flight flight = record([] {});
    return flight.at(flight.end_s(), kWidth, kHeight);
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

}  // namespace tintree::view
