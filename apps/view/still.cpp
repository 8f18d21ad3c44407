#include "apps/view/still.h"

#include <algorithm>
#include <ctime>
#include <functional>
#include <limits>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/common/json_file.h"
#include "apps/view/debug_lines.h"
#include "apps/view/picture_file.h"
#include "apps/view/shortfalls.h"
#include "render/terrain_scene.h"

namespace tintree::view {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSamples = 4;

double seconds_since(Clock::time_point begun) { return std::chrono::duration<double>(Clock::now() - begun).count(); }

struct Figures {
  render::LodCut cut;
  render::DrawStats drawn;
  double load_seconds = 0;
  double frame_seconds = 0;
  double redraw_cpu_seconds = 0;
  double seconds = 0;
};

/// The least processor time, of all threads, of three more drawings: without what only the first one costs.
double redraw_cpu_seconds(const render::GlFunctions& gl, const std::function<void()>& draw) {
  std::clock_t least = std::numeric_limits<std::clock_t>::max();
  for (int i = 0; i < 3; ++i) {
    const std::clock_t before = std::clock();
    draw();
    gl.Finish();
    least = std::min(least, std::clock() - before);
  }
  return static_cast<double>(least) / CLOCKS_PER_SEC;
}

nlohmann::ordered_json to_json(const Figures& f, const render::Camera& camera, const ViewOptions& options,
                               render::TerrainScene::Stores stores, const cache::TileCache::Stats& cache,
                               const std::string& renderer) {
  return {
      {"tree", stores.front()->path()},
      {"digest", stores.front()->manifest().digest},
      {"screenshot", options.screenshot},
      {"width_px", camera.width_px},
      {"height_px", camera.height_px},
      {"eye_m", {camera.eye.x, camera.eye.y, camera.eye.z}},
      {"target_m", {camera.target.x, camera.target.y, camera.target.z}},
      {"fov_y_rad", camera.fov_y_rad},
      {"pixel_error", options.pixel_error},
      {"max_error_px", f.cut.max_error_px},
      {"leaf_limited_tiles", f.cut.leaf_limited},
      {"tiles", f.drawn.tiles},
      {"triangles", f.drawn.triangles},
      {"loaded_tiles", cache.loaded},
      {"bytes_read", cache.bytes_read},
      {"load_seconds", f.load_seconds},
      {"frame_seconds", f.frame_seconds},
      {"redraw_cpu_seconds", f.redraw_cpu_seconds},
      {"seconds", f.seconds},
      {"peak_rss_bytes", app::peak_rss_bytes()},
      {"renderer", renderer},
  };
}

}  // namespace

Expected<void> draw_still(const render::GlFunctions& gl, render::TerrainScene::Stores stores,
                          const ViewOptions& options, Clock::time_point begun) {
  const auto target = render::OffscreenTarget::create(gl, options.width_px, options.height_px, kSamples);
  if (!target) return tl::unexpected(target.error());
  render::SceneOptions wanted = scene_options(options);
  wanted.impostors = false;  // They would be drawn for one picture.
  const auto scene = render::TerrainScene::create(gl, stores, wanted);
  if (!scene) return tl::unexpected(scene.error());
  const auto camera = first_camera(options, (*scene)->trees());
  if (!camera) return tl::unexpected(camera.error());

  const auto lines = render::LineDrawer::create(gl);
  if (!lines) return tl::unexpected(lines.error());

  Figures figures;
  const auto loading = Clock::now();
  auto cut = (*scene)->settle(*camera);
  if (!cut) return tl::unexpected(cut.error());
  Shortfalls shortfalls;
  shortfalls.note(**scene, options);
  figures.cut = std::move(*cut);
  figures.load_seconds = seconds_since(loading);
  render::Style style = options.style;
  style.allowed_px = options.pixel_error;
  gl.Finish();
  const auto drawing = Clock::now();
  figures.drawn = (*scene)->draw(*target, *camera, figures.cut, style);
  gl.Finish();
  figures.frame_seconds = seconds_since(drawing);
  if (!options.json.empty())
    figures.redraw_cpu_seconds = redraw_cpu_seconds(gl, [&] { (*scene)->draw(*target, *camera, figures.cut, style); });
  if (options.boxes) {
    const auto boxes = box_lines((*scene)->trees(), figures.cut);
    lines->draw(*target, *camera, (*scene)->renderer().near_m(figures.cut), boxes);
  }
  if (!options.screenshot.empty()) {
    if (auto written = write_png(options.screenshot, target->read_picture()); !written) return written;
  }
  figures.seconds = seconds_since(begun);
  if (!options.json.empty()) {
    const auto json = to_json(figures, *camera, options, stores, (*scene)->cache().stats(), gl.renderer);
    if (auto written = app::write_json(options.json, json); !written) return written;
  }
  if (!options.quiet) {
    fmt::print(
        "{}{}x{} pixels, {} tiles, {} triangles, largest error {:.2f} pixels, loaded in {:.2f} s, drawn in {:.2f} s\n",
        options.screenshot.empty() ? "" : options.screenshot + ": ", camera->width_px, camera->height_px,
        figures.drawn.tiles, figures.drawn.triangles, figures.cut.max_error_px, figures.load_seconds,
        figures.frame_seconds);
  }
  return shortfalls.outcome();
}

}  // namespace tintree::view
