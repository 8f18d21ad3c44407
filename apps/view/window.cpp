#include "apps/view/window.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/core.h>
#include <glm/geometric.hpp>

#include "apps/common/program.h"
#include "apps/view/navigation.h"
#include "apps/view/picture_file.h"
#include "apps/view/still.h"
#include "render/terrain_scene.h"

namespace tintree::view {
namespace {

constexpr int kSamples = 4;
constexpr std::size_t kUploadBytes = std::size_t{8} << 20;

/// GLFW itself and one window with its context current.
class GlfwWindow {
 public:
  static Expected<std::unique_ptr<GlfwWindow>> create(int width, int height, const std::string& title, bool visible) {
    if (glfwInit() == GLFW_FALSE) {
      return fail(ErrorCode::kIo,
                  "there is no display to open a window on; use --headless osmesa --screenshot FILE.png");
    }
    std::unique_ptr<GlfwWindow> out(new GlfwWindow);
    for (const auto& [major, minor] : {std::pair(4, 5), std::pair(3, 3)}) {
      glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, major);
      glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, minor);
      glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
      glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
      glfwWindowHint(GLFW_VISIBLE, visible ? GLFW_TRUE : GLFW_FALSE);
      out->handle_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
      if (out->handle_ != nullptr) break;
    }
    if (out->handle_ == nullptr) {
      const char* reason = nullptr;
      glfwGetError(&reason);
      return fail(ErrorCode::kIo, fmt::format("no window with OpenGL 3.3 can be opened ({}); use --headless osmesa",
                                              reason == nullptr ? "no reason given" : reason));
    }
    glfwMakeContextCurrent(out->handle_);
    glfwSwapInterval(1);
    return out;
  }

  ~GlfwWindow() {
    if (handle_ != nullptr) glfwDestroyWindow(handle_);
    glfwTerminate();
  }
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  GLFWwindow* handle() const { return handle_; }

 private:
  GlfwWindow() = default;
  GLFWwindow* handle_ = nullptr;
};

/// What the user does to the camera, and what is on the screen.
class Viewer {
 public:
  Viewer(GLFWwindow* window, const render::GlFunctions& gl, render::TerrainScene& scene, const ViewOptions& options,
         const render::Camera& camera)
      : window_(window), gl_(gl), scene_(scene), options_(options), home_(camera), camera_(camera) {
    const cache::Box box = scene.bounds().box(scene.bounds().nodes().front());
    const double diagonal = std::hypot(box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2]);
    limits_ = {2 * scene.bounds().layout().dx_m, 10 * diagonal};
    glfwSetWindowUserPointer(window, this);
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double steps) { self(w).on_wheel(steps); });
    glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) { self(w).on_cursor(x, y); });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int, int action, int) { self(w).on_button(action); });
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) { self(w).on_key(key, action); });
    glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { self(w).stale_ = true; });
  }

  Expected<void> run() {
    while (glfwWindowShouldClose(window_) == GLFW_FALSE) {
      if (app::stop_requested()) return fail(ErrorCode::kStopped, "stopped");
      // With nothing to do it sleeps, but wakes to notice a stop.
      stale_ ? glfwPollEvents() : glfwWaitEventsTimeout(0.25);
      walk_by_keys();
      if (auto sized = fit_target(); !sized) return sized;
      if (stale_ && target_) draw();
    }
    return {};
  }

 private:
  static Viewer& self(GLFWwindow* w) { return *static_cast<Viewer*>(glfwGetWindowUserPointer(w)); }

  bool pressed(int button) const { return glfwGetMouseButton(window_, button) == GLFW_PRESS; }
  bool held(int key) const { return glfwGetKey(window_, key) == GLFW_PRESS; }

  /// Pixels of the frame a screen unit of the cursor.
  double scale() const {
    int window_width = 1;
    glfwGetWindowSize(window_, &window_width, nullptr);
    return static_cast<double>(camera_.width_px) / std::max(window_width, 1);
  }

  std::optional<double> depth_at(double x_px, double y_px) const {
    if (!target_) return std::nullopt;
    const float stored = target_->read_depth(static_cast<int>(x_px), static_cast<int>(y_px));
    if (!(stored > 0)) return std::nullopt;
    return near_m_ / static_cast<double>(stored);
  }

  void move_to(const render::Camera& camera) {
    camera_ = camera;
    stale_ = true;
  }

  void on_wheel(double steps) {
    const double x = cursor_x_ * scale();
    const double y = cursor_y_ * scale();
    move_to(zoom(camera_, point_under(camera_, x, y, depth_at(x, y)), std::pow(0.85, steps), limits_));
  }

  void on_cursor(double x, double y) {
    const double dx = (x - cursor_x_) * scale();
    const double dy = (y - cursor_y_) * scale();
    cursor_x_ = x;
    cursor_y_ = y;
    if (pressed(GLFW_MOUSE_BUTTON_LEFT)) {
      move_to(orbit(camera_, dx, dy));
    } else if (pressed(GLFW_MOUSE_BUTTON_RIGHT) || pressed(GLFW_MOUSE_BUTTON_MIDDLE)) {
      move_to(pan(camera_, dx, dy));
    }
  }

  void on_button(int action) {
    if (action == GLFW_PRESS) anchor_to_ground();
  }

  /// The drag that begins turns or moves about what is in the middle of the picture.
  void anchor_to_ground() {
    if (const auto depth = depth_at(0.5 * camera_.width_px, 0.5 * camera_.height_px))
      camera_ = anchor(camera_, *depth, limits_);
  }

  void on_key(int key, int action) {
    if (action != GLFW_PRESS) return;
    switch (key) {
      case GLFW_KEY_ESCAPE:
        glfwSetWindowShouldClose(window_, GLFW_TRUE);
        break;
      case GLFW_KEY_R:
      case GLFW_KEY_HOME:
        move_to(home_);
        break;
      case GLFW_KEY_F:
        style_.wireframe = !style_.wireframe;
        stale_ = true;
        break;
      case GLFW_KEY_F12:
        save_picture();
        break;
      default:
        break;
    }
  }

  void walk_by_keys() {
    const double now = glfwGetTime();
    const double seconds = std::min(now - walked_at_, 0.1);
    walked_at_ = now;
    const auto either = [this](int a, int b) { return held(a) || held(b) ? 1 : 0; };
    const int ahead = either(GLFW_KEY_W, GLFW_KEY_UP) - either(GLFW_KEY_S, GLFW_KEY_DOWN);
    const int right = either(GLFW_KEY_D, GLFW_KEY_RIGHT) - either(GLFW_KEY_A, GLFW_KEY_LEFT);
    if (ahead != 0 || right != 0) move_to(walk(camera_, 0.7 * seconds * ahead, 0.7 * seconds * right));
  }

  /// Keeps the frame as large as the window's.
  Expected<void> fit_target() {
    int width = 0;
    int height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    if (width <= 0 || height <= 0 || (target_ && target_->width_px() == width && target_->height_px() == height))
      return {};
    auto target = render::OffscreenTarget::create(gl_, width, height, kSamples);
    if (!target) return tl::unexpected(target.error());
    target_.reset();
    target_.emplace(std::move(*target));
    camera_.width_px = home_.width_px = width;
    camera_.height_px = home_.height_px = height;
    stale_ = true;
    return {};
  }

  void draw() {
    const double begun = glfwGetTime();
    const render::LodCut cut = scene_.update(camera_, begun);
    near_m_ = scene_.renderer().near_m(cut);
    const render::DrawStats drawn = scene_.draw(*target_, camera_, cut, style_);
    target_->show_in_window();
    glfwSwapBuffers(window_);
    for (const Error& e : scene_.take_errors()) fmt::print(stderr, "tintree-view: {}\n", e.text());
    // Goes on drawing while tiles come; those that cannot be loaded are not waited for.
    stale_ = scene_.busy(cut);
    show_figures(cut, drawn, glfwGetTime() - begun);
  }

  void show_figures(const render::LodCut& cut, const render::DrawStats& drawn, double seconds) {
    const std::string title = fmt::format("{} - {} triangles, {} tiles, {:.2f} px, {:.0f} ms{}",
                                          std::filesystem::path(options_.trees.front()).filename().string(),
                                          drawn.triangles, drawn.tiles, cut.max_error_px, 1e3 * seconds,
                                          cut.complete ? "" : fmt::format(", {} tiles to come", cut.requests.size()));
    glfwSetWindowTitle(window_, title.c_str());
  }

  void save_picture() {
    if (!target_) return;
    std::string path;
    for (int i = 1; path.empty() || std::filesystem::exists(path); ++i) path = fmt::format("tintree-{:03}.png", i);
    const auto written = write_png(path, target_->read_picture());
    if (!written) fmt::print(stderr, "tintree-view: {}\n", written.error().text());
    if (written && !options_.quiet) fmt::print("{}\n", path);
    std::fflush(stdout);
  }

  GLFWwindow* window_;
  const render::GlFunctions& gl_;
  render::TerrainScene& scene_;
  const ViewOptions& options_;
  render::Camera home_;
  render::Camera camera_;
  NavigationLimits limits_;
  render::Style style_;
  std::optional<render::OffscreenTarget> target_;
  double near_m_ = 1;
  double cursor_x_ = 0;
  double cursor_y_ = 0;
  double walked_at_ = 0;
  bool stale_ = true;
};

}  // namespace

Expected<void> run_window(render::TerrainScene::Stores stores, const ViewOptions& options,
                          std::chrono::steady_clock::time_point begun) {
  const bool still = !options.screenshot.empty();
  const auto window = GlfwWindow::create(options.width_px, options.height_px, options.trees.front(), !still);
  if (!window) return tl::unexpected(window.error());
  const auto gl = render::load_gl([](const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); });
  if (!gl) return tl::unexpected(gl.error());
  if (still) return draw_still(*gl, stores, options, begun);

  render::SceneOptions scene_options;
  scene_options.cut.pixel_error = options.pixel_error;
  scene_options.cut.morph = options.morph;
  scene_options.upload_bytes = kUploadBytes;
  scene_options.gpu_bytes = options.gpu_bytes;
  const auto scene = render::TerrainScene::create(*gl, stores, scene_options);
  if (!scene) return tl::unexpected(scene.error());
  const auto camera = first_camera(options, (*scene)->trees());
  if (!camera) return tl::unexpected(camera.error());
  return Viewer((*window)->handle(), *gl, **scene, options, *camera).run();
}

}  // namespace tintree::view
