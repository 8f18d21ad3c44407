// What the user does: the part of Viewer that GLFW's events reach.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "apps/common/program.h"
#include "apps/common/whole_file.h"
#include "apps/view/picture_file.h"
#include "apps/view/viewer.h"

namespace tintree::view {
namespace {

constexpr double kDoubleClick_s = 0.4;
constexpr double kDoubleClickApart = 6;  ///< Screen units.
constexpr double kNotice_s = 4;

bool with_shift(int mods) { return (mods & GLFW_MOD_SHIFT) != 0; }

/// The first of the names "STEM-001.END", "STEM-002.END", ... that no file has.
std::string free_name(const std::string& stem, const std::string& end) {
  std::string path;
  for (int i = 1; path.empty() || std::filesystem::exists(path); ++i) path = fmt::format("{}-{:03}{}", stem, i, end);
  return path;
}

}  // namespace

void Viewer::listen() {
  // A key that is let go before the next look at it counts once all the same.
  glfwSetInputMode(window_, GLFW_STICKY_KEYS, GLFW_TRUE);
  glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double steps) { self(w).on_wheel(steps); });
  glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) { self(w).on_cursor(x, y); });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int mods) {
    self(w).on_button(button, action == GLFW_PRESS, with_shift(mods));
  });
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int mods) {
    if (action == GLFW_PRESS) self(w).on_key(key, with_shift(mods));
  });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { self(w).text_stale_ = true; });
}

double Viewer::scale() const {
  int window_width = 1;
  glfwGetWindowSize(window_, &window_width, nullptr);
  return static_cast<double>(pilot_.camera().width_px) / std::max(window_width, 1);
}

bool Viewer::held(Action action) const {
  bool any = false;
  // Sticky keys are let go by looking at them: look at all.
  for (const int key : held_keys(action)) any = glfwGetKey(window_, key) == GLFW_PRESS || any;
  return any;
}

double Viewer::axis(Action more, Action less) const { return (held(more) ? 1.0 : 0.0) - (held(less) ? 1.0 : 0.0); }

void Viewer::on_wheel(double steps) {
  flights_.stop();
  pilot_.zoom_by(steps, cursor_px().x, cursor_px().y);
  stale_ = true;
}

void Viewer::on_cursor(double x, double y) {
  cursor_ = {x, y};
  text_stale_ = true;
  if (!dragging_) return;
  pilot_.drag_to(cursor_px().x, cursor_px().y);
  stale_ = true;
}

void Viewer::on_button(int button, bool pressed, bool shift) {
  if (!pressed) {
    pilot_.end_drag();
    dragging_ = false;
    return;
  }
  flights_.stop();
  const glm::dvec2 at = cursor_px();
  const bool twice = button == pressed_ && now_s_ - pressed_at_s_ < kDoubleClick_s &&
                     glm::distance(cursor_, pressed_at_) < kDoubleClickApart;
  pressed_at_s_ = twice ? -1 : now_s_;
  pressed_at_ = cursor_;
  pressed_ = button;
  if (twice && action_of(Input::kDoubleClick, button, shift) == Action::kGoThere) {
    pilot_.go_there(at.x, at.y);
    return;
  }
  const auto action = action_of(Input::kDrag, button, shift);
  if (!action) return;
  dragging_ = true;
  pilot_.begin_drag(*action == Action::kPan    ? Pilot::Drag::kPan
                    : *action == Action::kLook ? Pilot::Drag::kLook
                                               : Pilot::Drag::kOrbit,
                    at.x, at.y);
}

void Viewer::on_key(int key, bool shift) {
  const auto action = action_of(Input::kKey, key, shift);
  if (!action) return;
  once(*action);
  stale_ = true;
}

void Viewer::once(Action action) {
  const glm::dvec2 at = cursor_px();
  const auto toggle = [](bool& what) { what = !what; };
  switch (action) {
    case Action::kHome:
      return pilot_.go_home();
    case Action::kLookThere:
      return pilot_.look_there(at.x, at.y);
    case Action::kFlyMode:
      return pilot_.toggle_fly_mode();
    case Action::kRecord:
      return toggle_record();
    case Action::kPlay:
      return toggle_play();
    case Action::kPicture:
      return save_picture(false);
    case Action::kPictureWithText:
      return save_picture(true);
    case Action::kFinerError:
      return change_pixel_error(1 / std::numbers::sqrt2);
    case Action::kCoarserError:
      return change_pixel_error(std::numbers::sqrt2);
    case Action::kPlainColors:
      style_.tint = render::Tint::kHeight;
      return;
    case Action::kLevelColors:
      style_.tint = render::Tint::kLevel;
      return;
    case Action::kErrorColors:
      style_.tint = render::Tint::kError;
      return;
    case Action::kTriangles:
      return toggle(style_.wireframe);
    case Action::kBoxes:
      return toggle(boxes_);
    case Action::kFreeze:
      return toggle_freeze();
    case Action::kStatistics:
      return toggle(statistics_);
    case Action::kHelp:
      return toggle(help_);
    case Action::kQuit:
      glfwSetWindowShouldClose(window_, GLFW_TRUE);
      return;
    default:
      return;  // Held keys and the mouse: handled where they are read.
  }
}

void Viewer::change_pixel_error(double factor) {
  double& allowed = tools_.scene.cut_options().pixel_error;
  // From 0, the leaves, there is a way back.
  allowed = std::clamp(allowed * factor, 0.125, 64.0);
  notify(fmt::format("pixel error {:.3g}", allowed));
}

void Viewer::toggle_freeze() {
  frozen_ = frozen_ ? std::nullopt : std::optional(pilot_.camera());
  notify(frozen_ ? "tiles frozen: move on and look at them" : "tiles follow the view again");
}

void Viewer::toggle_record() {
  if (!flights_.recording()) {
    flights_.begin_recording(pilot_.camera(), now_s_);
    return;
  }
  const auto flight = flights_.end_recording(pilot_.camera(), now_s_);
  if (!flight) return notify(flight.error().text());
  const std::string path = free_name("tintree-flight", ".json");
  const auto written = app::write_whole_file(path, flight->to_json());
  if (!written) return report(written.error());
  if (!options_.quiet) fmt::print("{}\n", path);
  std::fflush(stdout);
  notify("saved " + path);
}

void Viewer::toggle_play() {
  if (flights_.playing()) {
    flights_.stop();
  } else if (!flights_.play(now_s_)) {
    notify("no flight yet: F9 records one");
  }
}

void Viewer::save_picture(bool with_text) {
  if (!target_) return;
  if (stale_) draw_scene();
  if (with_text) {
    target_->bind();
    const Hud hud = lay_out(hud_text(), target_->width_px(), target_->height_px(), scale());
    tools_.text.draw({target_->width_px(), target_->height_px()}, hud.panels, hud.lines, hud.size_px);
  }
  const std::string path = free_name("tintree", ".png");
  const auto written = write_png(path, target_->read_picture());
  if (!written) return report(written.error());
  if (!options_.quiet) fmt::print("{}\n", path);
  std::fflush(stdout);
  notify("saved " + path);
  stale_ = true;  // Text in the picture is not to stay on the screen.
}

void Viewer::report(const Error& error) {
  app::report_failure("tintree-view", error);
  notify(error.text());
}

void Viewer::notify(const std::string& text) {
  constexpr std::size_t kMost = 5;
  notices_.push_back({text, glfwGetTime() + kNotice_s});
  if (notices_.size() > kMost) notices_.pop_front();
  text_stale_ = true;
}

void Viewer::drop_old_notices() {
  while (!notices_.empty() && notices_.front().until_s < now_s_) {
    notices_.pop_front();
    text_stale_ = true;
  }
}

}  // namespace tintree::view
