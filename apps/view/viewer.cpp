#include "apps/view/viewer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "apps/common/program.h"
#include "apps/view/debug_lines.h"
#include "apps/view/places.h"
#include "apps/view/shortfalls.h"
#include "render/frozen_cut.h"
#include "render/picking.h"

namespace tintree::view {
namespace {

constexpr int kSamples = 4;
constexpr double kLongestStep_s = 0.1;
constexpr double kNap_s = 0.25;  ///< With nothing to do it sleeps, but wakes to notice a stop.
constexpr double kDegree = std::numbers::pi / 180;

NavigationLimits limits_of(render::Trees trees) {
  cache::Box all = trees.front()->box(trees.front()->nodes().front());
  for (const cache::TileBounds* tree : trees) {
    const cache::Box box = tree->box(tree->nodes().front());
    for (std::size_t i = 0; i < 3; ++i) {
      all.min[i] = std::min(all.min[i], box.min[i]);
      all.max[i] = std::max(all.max[i], box.max[i]);
    }
  }
  const double diagonal = std::hypot(all.max[0] - all.min[0], all.max[1] - all.min[1], all.max[2] - all.min[2]);
  return {2 * trees.front()->layout().dx_m, 10 * diagonal};
}

}  // namespace

Viewer::Viewer(GLFWwindow* window, Tools tools, const cache::Manifest& manifest, const ViewOptions& options,
               const render::Camera& camera, std::optional<render::Flight> flight)
    : window_(window),
      tools_(std::move(tools)),
      manifest_(manifest),
      options_(options),
      pilot_(camera, limits_of(tools_.scene.trees()), sense_ground()),
      flights_(std::move(flight)),
      style_(options.style),
      boxes_(options.boxes) {
  glfwSetWindowUserPointer(window, this);
  listen();
  if (flights_.play(glfwGetTime())) return;
  notify("H: help");
}

Viewer& Viewer::self(GLFWwindow* window) { return *static_cast<Viewer*>(glfwGetWindowUserPointer(window)); }

Viewer::Summary Viewer::summary() const {
  return {frames_, rests_, tile_errors_, tools_.scene.cut_options().pixel_error, pilot_.camera()};
}

Expected<void> Viewer::run() {
  now_s_ = glfwGetTime();
  while (glfwWindowShouldClose(window_) == GLFW_FALSE) {
    if (app::stop_requested()) return fail(ErrorCode::kStopped, "stopped");
    const auto drawable = fit_target();
    if (!drawable) return tl::unexpected(drawable.error());
    const double before = now_s_;
    if ((stale_ || moving_) && *drawable) {
      glfwPollEvents();
      now_s_ = glfwGetTime();
    } else {
      nap();
    }
    advance(std::min(now_s_ - before, kLongestStep_s));
    if (!*drawable) continue;
    if (stale_) draw_scene();
    if (text_stale_) present();
  }
  return {};
}

void Viewer::nap() {
  constexpr double kRest_s = 0.2;  // Whoever drags the mouse moves it more often.
  const double begun_s = glfwGetTime();
  glfwWaitEventsTimeout(kNap_s);
  now_s_ = glfwGetTime();
  if (now_s_ - begun_s < kRest_s) return;
  ++rests_;
  frame_rate_.rest();
  if (std::exchange(readings_.frames_per_second, 0) > 0) text_stale_ = true;
}

void Viewer::advance(double seconds) {
  drop_old_notices();
  moving_ = turn_sun(seconds);
  const Motion motion{axis(Action::kAhead, Action::kBack), axis(Action::kRight, Action::kLeft),
                      axis(Action::kUp, Action::kDown)};
  if (motion.ahead != 0 || motion.right != 0 || motion.up != 0) flights_.stop();
  const render::Camera& seen = pilot_.camera();
  if (const auto view = flights_.view(now_s_, seen.width_px, seen.height_px)) {
    pilot_.take(*view);
    moving_ = true;
  } else if (pilot_.advance(seconds, motion, held(Action::kFaster))) {
    moving_ = true;
  }
  stale_ = stale_ || moving_;
  if (flights_.recording()) {
    flights_.note(pilot_.camera(), now_s_);
    text_stale_ = true;
  }
}

bool Viewer::turn_sun(double seconds) {
  constexpr double kTurn = 60 * kDegree;
  const double east = axis(Action::kSunEast, Action::kSunWest) * seconds * kTurn;
  const double up = axis(Action::kSunUp, Action::kSunDown) * seconds * kTurn / 2;
  if (east == 0 && up == 0) return false;
  style_.sun_azimuth_rad = std::remainder(style_.sun_azimuth_rad + east, 2 * std::numbers::pi);
  style_.sun_elevation_rad = std::clamp(style_.sun_elevation_rad + up, kDegree, 90 * kDegree);
  return true;
}

GroundSense Viewer::sense_ground() {
  render::TerrainScene& scene = tools_.scene;
  const render::FindTile find = [&scene](const cache::TileRef& tile) { return scene.cache().get(tile); };
  GroundSense out;
  out.pick = [&scene, find](const render::Ray& ray) -> std::optional<glm::dvec3> {
    const auto hit = render::pick(scene.trees(), find, ray);
    if (!hit) return std::nullopt;
    return hit->at;
  };
  out.floor_m = [&scene, find](double x_m, double y_m) -> std::optional<double> {
    const auto ground = render::ground_at(scene.trees(), find, x_m, y_m);
    if (!ground) return std::nullopt;
    // Finer tiles than the one in memory may rise over it by its error, but no more.
    const cache::TileBounds& tree = *scene.trees()[ground->tree];
    const cache::TileNode& node = tree.nodes()[ground->node];
    const double error_m = node.child_mask == 0 ? 0 : static_cast<double>(node.lod_error_m);
    return ground->at.z + error_m + 0.25 * tree.layout().dx_m;
  };
  return out;
}

Expected<bool> Viewer::fit_target() {
  int width = 0;
  int height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  const bool hidden = glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE;
  if (hidden || width <= 0 || height <= 0) return false;
  if (target_ && target_->width_px() == width && target_->height_px() == height) return true;
  if (glm::ivec2(width, height) == refused_px_) return true;
  auto target = render::OffscreenTarget::create(tools_.gl, width, height, kSamples);
  if (!target) {
    if (!target_) return tl::unexpected(target.error());
    // In a window larger than the driver can draw, the picture stays as large as it was.
    refused_px_ = {width, height};
    report(target.error());
    return true;
  }
  target_.reset();
  target_.emplace(std::move(*target));
  pilot_.resize(width, height);
  stale_ = true;
  return true;
}

void Viewer::draw_scene() {
  const double begun_s = glfwGetTime();
  const render::Camera& camera = pilot_.camera();
  render::TerrainScene& scene = tools_.scene;
  const render::LodCut cut = scene.update(frozen_.value_or(camera), frozen_ ? std::nullopt : std::optional(now_s_));
  const render::LodCut shown = frozen_ ? render::seen_from(cut, scene.trees(), camera) : cut;
  style_.allowed_px = scene.cut_options().pixel_error;
  const render::DrawStats drawn = scene.draw(*target_, camera, shown, style_);
  std::vector<render::WorldLine> lines;
  if (boxes_) lines = box_lines(scene.trees(), shown);
  if (frozen_) std::ranges::copy(view_lines(*frozen_), std::back_inserter(lines));
  tools_.lines.draw(*target_, camera, scene.renderer().near_m(shown), lines);

  // Goes on drawing while tiles come; those that cannot be loaded are not waited for.
  stale_ = scene.busy(cut);
  take_tile_errors();
  tell_of_memory();
  text_stale_ = true;
  ++frames_;

  frame_rate_.note_frame(begun_s);
  const render::FrameStats& stats = scene.frame_stats();
  readings_ = {.frame_seconds = glfwGetTime() - begun_s,
               .frames_per_second = frame_rate_.per_second(),
               .triangles = drawn.triangles,
               .tiles = drawn.tiles,
               .culled = cut.culled,
               .occluded = cut.occluded,
               .hits = readings_.hits + stats.cache_hits,
               .misses = readings_.misses + stats.cache_misses,
               .cache_bytes = stats.cache_bytes,
               .gpu_bytes = stats.gpu_bytes,
               .max_error_px = cut.max_error_px,
               .allowed_px = style_.allowed_px,
               .to_come = cut.requests.size()};
}

void Viewer::take_tile_errors() {
  constexpr std::uint64_t kMostPrinted = 20;
  for (const Error& e : tools_.scene.take_errors()) {
    if (++tile_errors_ > kMostPrinted) continue;
    report(e);
    if (tile_errors_ == kMostPrinted) fmt::print(stderr, "tintree-view: further tiles that fail are not named\n");
  }
}

void Viewer::tell_of_memory() {
  if (!tools_.scene.frame_stats().gpu_memory_full || std::exchange(told_of_memory_, true)) return;
  report({ErrorCode::kUsage, too_little_memory(options_), "--gpu-memory"});
}

void Viewer::present() {
  text_stale_ = false;
  target_->show_in_window();
  const Hud hud = lay_out(hud_text(), target_->width_px(), target_->height_px(), scale());
  tools_.text.draw({target_->width_px(), target_->height_px()}, hud.panels, hud.lines, hud.size_px);
  glfwSwapBuffers(window_);
}

HudText Viewer::hud_text() const {
  HudText out;
  out.help = help_;
  if (statistics_) {
    out.figures = figures_text(readings_);
    const glm::dvec2 at = cursor_px();
    const auto ground = pilot_.ground_under(at.x, at.y);
    out.place = ground ? place_text(manifest_, *ground) : "no ground under the cursor";
    out.place += fmt::format(" · eye {:.0f} m over the ground", pilot_.height_m());
    if (pilot_.fly_mode()) out.place += " · fly mode";
    if (frozen_) out.place += " · tiles frozen";
  }
  if (flights_.recording()) out.notices.emplace_back("recording: F9 to save");
  for (const Notice& notice : notices_) out.notices.push_back(notice.text);
  return out;
}

}  // namespace tintree::view
