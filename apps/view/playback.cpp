#include "apps/view/playback.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/common/json_file.h"
#include "apps/common/program.h"
#include "apps/view/picture_file.h"
#include "apps/view/shortfalls.h"
#include "render/terrain_scene.h"

namespace tintree::view {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSamples = 4;

struct Frame {
  double flight_seconds = 0;  ///< Where on the flight.
  double seconds = 0;         ///< What it took.
  // Of its cut:
  double max_error_px = 0;
  std::uint32_t culled = 0;
  std::uint32_t occluded = 0;
  std::uint32_t wanted = 0;
  std::uint32_t late = 0;
  render::DrawStats drawn;
  render::FrameStats stats;
};

double seconds_since(Clock::time_point begun) { return std::chrono::duration<double>(Clock::now() - begun).count(); }

class Playback {
 public:
  Playback(const render::GlFunctions& gl, render::TerrainScene& scene, const render::OffscreenTarget& target,
           const render::Flight& flight, const ViewOptions& options)
      : gl_(gl), scene_(scene), target_(target), flight_(flight), options_(options) {}

  Expected<void> run() {
    // The flight begins with its first view on the screen.
    if (auto ready = scene_.settle(camera_at(flight_.begin_s())); !ready) return tl::unexpected(ready.error());
    const double length = flight_.end_s() - flight_.begin_s();
    const auto last = static_cast<std::int64_t>(std::floor(length * options_.fps + 1e-9));
    const Clock::time_point begun = Clock::now();
    for (std::int64_t i = 0; i <= last; ++i) {
      if (app::stop_requested()) return fail(ErrorCode::kStopped, "stopped");
      double at = static_cast<double>(i) / options_.fps;
      if (options_.real_time) {
        std::this_thread::sleep_until(begun +
                                      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(at)));
        at = std::max(at, seconds_since(begun));
        i = static_cast<std::int64_t>(at * options_.fps);
        if (at > length) break;
      }
      if (auto drawn = draw(flight_.begin_s() + at); !drawn) return drawn;
    }
    return {};
  }

  const std::vector<Frame>& frames() const { return frames_; }
  /// Fails with the first thing that kept the pictures from being whole.
  Expected<void> outcome() const { return shortfalls_.outcome(); }

 private:
  render::Camera camera_at(double seconds) const { return flight_.at(seconds, options_.width_px, options_.height_px); }

  Expected<void> draw(double seconds) {
    const render::Camera camera = camera_at(seconds);
    Frame frame;
    frame.flight_seconds = seconds;
    const Clock::time_point begun = Clock::now();
    Expected<render::LodCut> cut = options_.frames.empty() ? scene_.update(camera, seconds) : scene_.settle(camera);
    if (!cut) return tl::unexpected(cut.error());
    frame.drawn = scene_.draw(target_, camera, *cut, options_.style);
    gl_.Finish();
    frame.seconds = seconds_since(begun);
    frame.max_error_px = cut->max_error_px;
    frame.culled = cut->culled;
    frame.occluded = cut->occluded;
    frame.wanted = cut->wanted;
    frame.late = cut->late;
    frame.stats = scene_.frame_stats();
    shortfalls_.note(scene_, options_);
    frames_.push_back(frame);
    if (options_.frames.empty()) return {};
    return write_png(fmt::format("{}/frame-{:06}.png", options_.frames, frames_.size() - 1), target_.read_picture());
  }

  const render::GlFunctions& gl_;
  render::TerrainScene& scene_;
  const render::OffscreenTarget& target_;
  const render::Flight& flight_;
  const ViewOptions& options_;
  std::vector<Frame> frames_;
  Shortfalls shortfalls_;
};

/// The value that a share of the frames do not exceed.
double frame_seconds_quantile(const std::vector<Frame>& frames, double share) {
  std::vector<double> seconds;
  for (const Frame& f : frames) seconds.push_back(f.seconds);
  std::ranges::sort(seconds);
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(seconds.size())));
  return seconds[std::max<std::size_t>(rank, 1) - 1];
}

nlohmann::ordered_json to_json(const Frame& f) {
  return {
      {"flight_seconds", f.flight_seconds},
      {"frame_seconds", f.seconds},
      {"triangles", f.drawn.triangles},
      {"draw_calls", f.drawn.draw_calls},
      {"tiles", f.drawn.tiles},
      {"frustum_culled", f.culled},
      {"occluded", f.occluded},
      {"impostor_tiles", f.drawn.impostor_tiles},
      {"impostor_triangles", f.drawn.impostor_triangles},
      {"max_error_px", f.max_error_px},
      {"wanted_tiles", f.wanted},
      {"late_tiles", f.late},
      {"cache_hits", f.stats.cache_hits},
      {"cache_misses", f.stats.cache_misses},
      {"bytes_read", f.stats.bytes_read},
      {"uploads", f.stats.uploads},
      {"upload_bytes", f.stats.upload_bytes},
      {"cache_bytes", f.stats.cache_bytes},
      {"gpu_bytes", f.stats.gpu_bytes},
      {"gpu_memory_full", f.stats.gpu_memory_full},
  };
}

/// Sums and quantiles over all frames, then the frames.
nlohmann::ordered_json to_json(const std::vector<Frame>& frames, const render::GlFunctions& gl,
                               const ViewOptions& options) {
  const auto sum = [&](auto value) {
    std::uint64_t total = 0;
    for (const Frame& f : frames) total += value(f);
    return total;
  };
  nlohmann::ordered_json each = nlohmann::ordered_json::array();
  for (const Frame& f : frames) each.push_back(to_json(f));
  return {
      {"trees", options.trees},
      {"flight", options.flight},
      {"renderer", gl.renderer},
      {"width_px", options.width_px},
      {"height_px", options.height_px},
      {"pixel_error", options.pixel_error},
      {"gpu_memory_bytes", options.gpu_bytes},
      {"fps", options.fps},
      {"real_time", options.real_time},
      {"waits_for_tiles", !options.frames.empty()},
      {"frame_count", frames.size()},
      {"frame_seconds_median", frame_seconds_quantile(frames, 0.5)},
      {"frame_seconds_p99", frame_seconds_quantile(frames, 0.99)},
      {"frame_seconds_worst", frame_seconds_quantile(frames, 1)},
      {"triangles", sum([](const Frame& f) { return f.drawn.triangles; })},
      {"draw_calls", sum([](const Frame& f) { return f.drawn.draw_calls; })},
      {"frustum_culled", sum([](const Frame& f) { return f.culled; })},
      {"occluded", sum([](const Frame& f) { return f.occluded; })},
      {"impostor_tiles", sum([](const Frame& f) { return f.drawn.impostor_tiles; })},
      {"impostor_triangles", sum([](const Frame& f) { return f.drawn.impostor_triangles; })},
      {"bytes_read", sum([](const Frame& f) { return f.stats.bytes_read; })},
      {"cache_hits", sum([](const Frame& f) { return f.stats.cache_hits; })},
      {"cache_misses", sum([](const Frame& f) { return f.stats.cache_misses; })},
      {"uploads", sum([](const Frame& f) { return f.stats.uploads; })},
      {"late_tiles", sum([](const Frame& f) { return f.late; })},
      {"late_frames", sum([](const Frame& f) { return f.late > 0 ? 1 : 0; })},
      {"peak_rss_bytes", app::peak_rss_bytes()},
      {"frames", std::move(each)},
  };
}

Expected<void> publish(const std::vector<Frame>& frames, const render::GlFunctions& gl, const ViewOptions& options) {
  const auto json = to_json(frames, gl, options);
  if (!options.json.empty()) {
    if (auto written = app::write_json(options.json, json); !written) return written;
  }
  if (options.quiet) return {};
  const auto ms = [&](const char* key) { return 1e3 * json[key].get<double>(); };
  fmt::print(
      "{} frames of {}x{} pixels: median {:.1f} ms, 99th percentile {:.1f} ms, worst {:.1f} ms; {} with late tiles\n",
      frames.size(), options.width_px, options.height_px, ms("frame_seconds_median"), ms("frame_seconds_p99"),
      ms("frame_seconds_worst"), json["late_frames"].get<std::uint64_t>());
  return {};
}

Expected<void> make_folder(const std::string& folder) {
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) return fail(ErrorCode::kIo, "cannot be made: " + error.message() + "; choose another --frames", folder);
  return {};
}

}  // namespace

Expected<void> play_flight(const render::GlFunctions& gl, render::TerrainScene::Stores stores,
                           const render::Flight& flight, const ViewOptions& options) {
  if (auto made = make_folder(options.frames); !made) return made;
  const auto target = render::OffscreenTarget::create(gl, options.width_px, options.height_px, kSamples);
  if (!target) return tl::unexpected(target.error());
  const auto scene = render::TerrainScene::create(gl, stores, scene_options(options));
  if (!scene) return tl::unexpected(scene.error());
  Playback playback(gl, **scene, *target, flight, options);
  if (auto played = playback.run(); !played) return played;
  if (auto published = publish(playback.frames(), gl, options); !published) return published;
  return playback.outcome();
}

}  // namespace tintree::view
