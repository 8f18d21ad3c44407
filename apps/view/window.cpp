#include "apps/view/window.h"

#include <filesystem>
#include <utility>

#include <nlohmann/json.hpp>

#include "apps/common/json_file.h"
#include "apps/view/glfw_window.h"
#include "apps/view/still.h"
#include "apps/view/viewer.h"
#include "render/terrain_scene.h"

namespace tintree::view {
namespace {

using Clock = std::chrono::steady_clock;

nlohmann::ordered_json to_json(const Viewer::Summary& s, const cache::TileStore& store, Clock::time_point begun,
                               const std::string& renderer) {
  const render::Camera& c = s.camera;
  return {
      {"tree", store.path()},
      {"digest", store.manifest().digest},
      {"width_px", c.width_px},
      {"height_px", c.height_px},
      {"eye_m", {c.eye.x, c.eye.y, c.eye.z}},
      {"target_m", {c.target.x, c.target.y, c.target.z}},
      {"fov_y_rad", c.fov_y_rad},
      {"pixel_error", s.pixel_error},
      {"frames", s.frames},
      {"rests", s.rests},
      {"tile_errors", s.tile_errors},
      {"seconds", std::chrono::duration<double>(Clock::now() - begun).count()},
      {"peak_rss_bytes", app::peak_rss_bytes()},
      {"renderer", renderer},
  };
}

Expected<void> show(GlfwWindow& window, const render::GlFunctions& gl, render::TerrainScene::Stores stores,
                    const ViewOptions& options, std::optional<render::Flight> flight, Clock::time_point begun) {
  const auto scene = render::TerrainScene::create(gl, stores, scene_options(options));
  if (!scene) return tl::unexpected(scene.error());
  const auto camera = first_camera(options, (*scene)->trees());
  if (!camera) return tl::unexpected(camera.error());
  auto text = render::TextDrawer::create(gl);
  if (!text) return tl::unexpected(text.error());
  auto lines = render::LineDrawer::create(gl);
  if (!lines) return tl::unexpected(lines.error());
  Viewer viewer(window.handle(), {gl, **scene, std::move(*text), std::move(*lines)}, stores.front()->manifest(),
                options, *camera, std::move(flight));
  if (auto done = viewer.run(); !done) return done;
  if (options.json.empty()) return {};
  return app::write_json(options.json, to_json(viewer.summary(), *stores.front(), begun, gl.renderer));
}

}  // namespace

Expected<void> run_window(render::TerrainScene::Stores stores, const ViewOptions& options,
                          std::optional<render::Flight> flight, Clock::time_point begun) {
  const bool still = !options.screenshot.empty();
  const std::string title = std::filesystem::path(options.trees.front()).filename().string() + " - tintree";
  const auto window = GlfwWindow::create(options.width_px, options.height_px, title, !still);
  if (!window) return tl::unexpected(window.error());
  const auto gl = render::load_gl(GlfwWindow::get_function());
  if (!gl) return tl::unexpected(gl.error());
  if (still) return draw_still(*gl, stores, options, begun);
  return show(**window, *gl, stores, options, std::move(flight), begun);
}

}  // namespace tintree::view
