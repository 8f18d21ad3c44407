#include "apps/view/view_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>
#include <string_view>
#include <vector>

#include <glm/geometric.hpp>

namespace tintree::view {
namespace {

constexpr double kElevation = 38 * std::numbers::pi / 180;
constexpr double kAzimuth = std::numbers::pi;  // South.
constexpr int kMostPixels = 16384;
constexpr int kMostGpuMib = 1 << 20;
constexpr std::size_t kUploadBytes = std::size_t{8} << 20;  // a frame

template <typename Number>
bool take_number(std::string_view& text, Number& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

bool take(std::string_view& text, char c) {
  if (text.empty() || text.front() != c) return false;
  text.remove_prefix(1);
  return true;
}

Expected<std::optional<glm::dvec3>> read_point(std::string_view text, const char* option) {
  if (text.empty()) return std::nullopt;
  glm::dvec3 p(0);
  const bool read =
      take_number(text, p.x) && take(text, ',') && take_number(text, p.y) && take(text, ',') && take_number(text, p.z);
  if (!read || !text.empty() || !std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
    return fail(ErrorCode::kUsage, "wants three numbers in metres, X,Y,Z, as in 1000,-2500.5,1800", option);
  }
  return p;
}

Expected<void> read_size(std::string_view text, ViewOptions& out) {
  if (text.empty()) return {};
  const bool read =
      take_number(text, out.width_px) && take(text, 'x') && take_number(text, out.height_px) && text.empty();
  const auto sane = [](int v) { return v >= 1 && v <= kMostPixels; };
  if (!read || !sane(out.width_px) || !sane(out.height_px)) {
    return fail(ErrorCode::kUsage, "wants WIDTHxHEIGHT in pixels, 1 to 16384 each, as in 1280x720", "--size");
  }
  return {};
}

/// Corners of the boxes of the finest level that has at most a few hundred tiles: they hug the terrain
/// better than the root's box.
void add_outline(const cache::TileBounds& bounds, std::vector<glm::dvec3>& corners) {
  constexpr std::size_t kEnough = 300;
  std::size_t first = 0;
  std::size_t end = bounds.nodes().size();
  for (std::size_t i = 0, begun = 0; i <= end; ++i) {
    if (i < end && bounds.nodes()[i].id.level == bounds.nodes()[begun].id.level) continue;
    if (i - begun > kEnough) break;
    first = begun;
    begun = i;
  }
  const int level = end == 0 ? 0 : bounds.nodes()[first].id.level;
  for (std::size_t i = first; i < end && bounds.nodes()[i].id.level == level; ++i) {
    const cache::Box box = bounds.box(bounds.nodes()[i]);
    for (unsigned c = 0; c < 8; ++c) {
      corners.emplace_back((c & 1U) != 0 ? box.max[0] : box.min[0], (c & 2U) != 0 ? box.max[1] : box.min[1],
                           (c & 4U) != 0 ? box.max[2] : box.min[2]);
    }
  }
}

Expected<void> read_sun(std::string_view text, render::Style& out) {
  if (text.empty()) return {};
  double azimuth = 0;
  double elevation = 0;
  const bool read = take_number(text, azimuth) && take(text, ',') && take_number(text, elevation) && text.empty();
  if (!read || !(azimuth >= -360 && azimuth <= 360) || !(elevation >= 0 && elevation <= 90)) {
    return fail(ErrorCode::kUsage, "wants AZIMUTH,ELEVATION in degrees, clockwise from north and 0 to 90, as in 315,34",
                "--sun");
  }
  out.sun_azimuth_rad = azimuth * std::numbers::pi / 180;
  out.sun_elevation_rad = elevation * std::numbers::pi / 180;
  return {};
}

Expected<void> read_show(std::span<const std::string> names, ViewOptions& out) {
  for (const std::string& name : names) {
    if (name == "levels") {
      out.style.tint = render::Tint::kLevel;
    } else if (name == "error") {
      out.style.tint = render::Tint::kError;
    } else if (name == "triangles") {
      out.style.wireframe = true;
    } else if (name == "boxes") {
      out.boxes = true;
    } else {
      return fail(ErrorCode::kUsage, "wants levels, error, triangles or boxes", "--show");
    }
  }
  return {};
}

}  // namespace

Expected<ViewOptions> read_options(const CommandLine& line) {
  ViewOptions out;
  out.trees = line.trees;
  out.gpu_bytes = static_cast<std::size_t>(std::max(line.gpu_memory_mib, 0)) << 20;
  out.pixel_error = line.pixel_error;
  out.screenshot = line.screenshot;
  out.flight = line.flight;
  out.frames = line.frames;
  out.fps = line.fps;
  out.real_time = line.real_time;
  out.json = line.json;
  out.quiet = line.quiet;
  out.morph = line.morph;
  out.impostors = line.impostors;
  if (!std::isfinite(line.fog_m) || line.fog_m < 0)
    return fail(ErrorCode::kUsage, "wants a distance in metres, 0 or more", "--fog");
  out.style.fog_m = line.fog_m;
  if (!std::isfinite(line.pixel_error) || line.pixel_error < 0) {
    return fail(ErrorCode::kUsage, "wants a number of pixels, 0 or more", "--pixel-error");
  }
  if (line.gpu_memory_mib < 1 || line.gpu_memory_mib > kMostGpuMib)
    return fail(ErrorCode::kUsage, "wants MiB of graphics memory for tiles, 1 to 1048576", "--gpu-memory");
  if (!(line.fps > 0 && line.fps <= 10000))
    return fail(ErrorCode::kUsage, "wants frames a second, more than 0 and at most 10000", "--fps");
  if (!line.frames.empty() && line.flight.empty())
    return fail(ErrorCode::kUsage, "wants a --flight to take frames of; for one picture use --screenshot", "--frames");
  if (!line.frames.empty() && line.real_time)
    return fail(ErrorCode::kUsage, "writes every frame and takes its time; leave out --real-time", "--frames");
  if (!line.flight.empty() && !line.screenshot.empty())
    return fail(ErrorCode::kUsage, "is one picture; leave out --flight, or take --frames of it", "--screenshot");
  if (line.headless == "egl") out.headless = render::Headless::kEgl;
  if (line.headless == "osmesa") out.headless = render::Headless::kOsMesa;
  if (!line.headless.empty() && !out.headless) return fail(ErrorCode::kUsage, "wants egl or osmesa", "--headless");
  if (auto read = read_show(line.show, out); !read) return tl::unexpected(read.error());
  if (auto read = read_sun(line.sun, out.style); !read) return tl::unexpected(read.error());
  if (auto read = read_size(line.size, out); !read) return tl::unexpected(read.error());
  auto eye = read_point(line.eye, "--eye");
  if (!eye) return tl::unexpected(eye.error());
  auto target = read_point(line.target, "--target");
  if (!target) return tl::unexpected(target.error());
  out.eye = *eye;
  out.target = *target;
  return out;
}

render::SceneOptions scene_options(const ViewOptions& options) {
  render::SceneOptions out;
  out.cut.pixel_error = options.pixel_error;
  out.cut.morph = options.morph;
  out.impostors = options.impostors;
  out.gpu_bytes = options.gpu_bytes;
  out.upload_bytes = kUploadBytes;
  return out;
}

Expected<render::Camera> first_camera(const ViewOptions& options, render::Trees trees) {
  std::vector<glm::dvec3> corners;
  for (const cache::TileBounds* tree : trees) add_outline(*tree, corners);
  render::Camera camera = render::overview(corners, kAzimuth, kElevation, options.width_px, options.height_px);
  const glm::dvec3 away = camera.eye - camera.target;
  if (options.target) {
    camera.target = *options.target;
    camera.eye = camera.target + away / 3.0;
  }
  if (options.eye) camera.eye = *options.eye;
  if (glm::length(camera.target - camera.eye) < 1e-6) {
    return fail(ErrorCode::kUsage, "is the same point as the target; choose another", "--eye");
  }
  return camera;
}

}  // namespace tintree::view
