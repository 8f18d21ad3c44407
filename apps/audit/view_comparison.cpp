#include "apps/audit/view_comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>
#include <optional>
#include <unordered_map>
#include <utility>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

#include "apps/audit/color_scale.h"
#include "apps/audit/mesh_heights.h"

namespace tintree::audit {
namespace {

constexpr double kMiss = SurfaceRays::kMiss;
/// Depths this near each other, as shares, are one: the driver places vertices on a lattice of its own.
constexpr double kDepthTolerance = 2e-3;
/// Rays a pixel's width, where outlines are looked for between pixels.
constexpr int kSubPixels = 4;
constexpr double kMostCells = 65536;
/// Rings on which the surface is looked at round a drawn point.
constexpr int kRings = 8;
constexpr int kRingPoints = 24;

/// Where points of the world lie in the picture.
class Screen {
 public:
  explicit Screen(const render::Camera& camera) : camera_(camera), axes_(camera.axes()), focal_px_(camera.focal_px()) {}

  /// Pixels from the middle; the point is before the eye.
  std::array<double, 2> at(const glm::dvec3& point) const {
    const glm::dvec3 p = point - camera_.eye;
    const double depth = glm::dot(p, axes_.forward);
    return {focal_px_ * glm::dot(p, axes_.right) / depth, focal_px_ * glm::dot(p, axes_.up) / depth};
  }

  double distance_px(const glm::dvec3& a, const glm::dvec3& b) const {
    const auto p = at(a);
    const auto q = at(b);
    return std::hypot(p[0] - q[0], p[1] - q[1]);
  }

 private:
  const render::Camera& camera_;
  render::CameraAxes axes_;
  double focal_px_;
};

struct OutlineCounts {
  std::uint64_t crack_px = 0;
  std::uint64_t silhouette_px = 0;
};

class Comparison {
 public:
  Comparison(const AuditContext& context, const SurfaceRays& rays, const DrawnView& drawn, double pixel_error)
      : layout_(context.store.manifest().layout),
        context_(context),
        rays_(rays),
        drawn_(drawn),
        camera_(drawn.camera),
        screen_(camera_),
        width_(camera_.width_px),
        height_(camera_.height_px),
        surface_m_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), kMiss),
        shifts_px_(surface_m_.size(), std::numeric_limits<double>::quiet_NaN()) {
    report_.limit_px = std::max(pixel_error, drawn.cut.max_error_px);
    reach_ = static_cast<int>(std::ceil(std::min(report_.limit_px, 16.0) - 1e-6));
    for (const render::DrawTile& d : drawn.cut.draws) {
      drawn_tiles_.emplace(context.store.bounds().nodes()[d.node].id.key(), std::vector<std::size_t>());
    }
  }

  Expected<ViewReport> run() {
    each_row([this](int y) { return cast_row(y); });
    file_pixels();
    std::vector<std::pair<codec::TileId, const std::vector<std::size_t>*>> tiles;
    for (const auto& [key, pixels] : drawn_tiles_) tiles.emplace_back(codec::TileId::from_key(key), &pixels);
    tbb::parallel_for(std::size_t{0}, tiles.size(),
                      [&](std::size_t i) { compare_tile(tiles[i].first, *tiles[i].second); });
    std::vector<double> drawn_px(static_cast<std::size_t>(height_), 0);
    each_row([&](int y) { return compare_drawn_row(y, drawn_px[static_cast<std::size_t>(y)]); });
    std::vector<OutlineCounts> outlines(static_cast<std::size_t>(height_));
    each_row([&](int y) { return compare_outline_row(y, outlines[static_cast<std::size_t>(y)]); });
    if (error_) return tl::unexpected(*error_);
    for (const OutlineCounts& row : outlines) {
      report_.crack_px += row.crack_px;
      report_.silhouette_px += row.silhouette_px;
    }
    report_.drawn_max_px = std::ranges::max(drawn_px);
    summarise_shifts();
    return std::move(report_);
  }

 private:
  template <typename Work>
  void each_row(const Work& work) {
    tbb::parallel_for(0, height_, [&](int y) {
      if (const std::optional<Error> error = work(y)) keep(*error);
    });
  }

  void keep(const Error& error) {
    const std::scoped_lock lock(turn_);
    if (!error_) error_ = error;
  }

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  glm::dvec3 ray(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(width_);
    return camera_.ray(static_cast<double>(pixel % width) + 0.5, static_cast<double>(pixel / width) + 0.5);
  }
  glm::dvec3 point(std::size_t pixel, double depth_m) const { return camera_.eye + depth_m * ray(pixel); }
  double column(const glm::dvec3& p) const { return layout_.grid(p.x, p.y)[0]; }
  double row(const glm::dvec3& p) const { return layout_.grid(p.x, p.y)[1]; }

  GridRay grid_ray(const glm::dvec3& d) const {
    return {{column(camera_.eye), row(camera_.eye), camera_.eye.z}, {column(d), row(d), d.z}};
  }

  /// Where the surface is seen, as depths along the view.
  std::optional<Error> cast_row(int y) {
    for (int x = 0; x < width_; ++x) {
      const glm::dvec3 d = ray(index(x, y));
      const auto hit = rays_.cast(grid_ray(d));
      if (!hit) return hit.error();
      surface_m_[index(x, y)] = *hit;
    }
    return std::nullopt;
  }

  /// Files every pixel under the drawn tile that holds its surface point.
  void file_pixels() {
    for (std::size_t i = 0; i < surface_m_.size(); ++i) {
      if (surface_m_[i] == kMiss) continue;
      ++report_.terrain_px;
      const glm::dvec3 p = point(i, surface_m_[i]);
      const auto c = static_cast<std::int64_t>(std::clamp(column(p), 0.0, static_cast<double>(layout_.columns - 2)));
      const auto r = static_cast<std::int64_t>(std::clamp(row(p), 0.0, static_cast<double>(layout_.rows - 2)));
      bool found = false;
      for (int level = 0; level <= layout_.leaf_level && !found; ++level) {
        const std::int64_t across = layout_.cells_across(level);
        const codec::TileId id{level, static_cast<std::uint32_t>(c / across), static_cast<std::uint32_t>(r / across)};
        const auto at = drawn_tiles_.find(id.key());
        found = at != drawn_tiles_.end();
        if (found) at->second.push_back(i);
      }
      // Seen, but no tile drawn there.
      if (!found) shifts_px_[i] = kMiss;
    }
  }

  void compare_tile(const codec::TileId& id, const std::vector<std::size_t>& pixels) {
    if (pixels.empty()) return;
    const auto mesh = context_.store.read_mesh(id);
    if (!mesh) return keep(mesh.error());
    const TileSurface surface = place(layout_, id, *mesh);
    const MeshHeights heights(surface);
    double largest_px = 0;
    for (const std::size_t i : pixels) {
      const glm::dvec3 p = point(i, surface_m_[i]);
      const double z = heights.at(column(p), row(p));
      shifts_px_[i] = std::isnan(z) ? kMiss : screen_.distance_px(p, {p.x, p.y, z});
      const double footprint_m = surface_m_[i] / camera_.focal_px();
      largest_px = std::max(largest_px, std::isnan(z) ? kMiss : std::abs(z - p.z) / footprint_m);
    }
    const std::scoped_lock lock(turn_);
    report_.distance_max_px = std::max(report_.distance_max_px, largest_px);
  }

  std::optional<Error> compare_drawn_row(int y, double& largest_px) const {
    for (int x = 0; x < width_; ++x) {
      const std::size_t i = index(x, y);
      if (drawn_.bare_depths_m[i] == kMiss || near_surface_depth(x, y)) continue;
      const glm::dvec3 p = point(i, drawn_.bare_depths_m[i]);
      const auto z = rays_.height(column(p), row(p));
      if (!z) return z.error();
      // Where the surface has an end or a hole, outlines are compared.
      if (std::isnan(*z)) continue;
      double off_px = screen_.distance_px(p, {p.x, p.y, *z});
      if (off_px > report_.limit_px) {
        const auto aside_px = distance_px(p, drawn_.bare_depths_m[i], *z);
        if (!aside_px) return aside_px.error();
        off_px = std::min(off_px, *aside_px);
      }
      largest_px = std::max(largest_px, off_px);
    }
    return std::nullopt;
  }

  /// At most how far a point is from the surface in any direction, in pixels of its depth: on walls the surface
  /// straight above or below is not the nearest one. The surface is without gaps, so over a disc it has every
  /// height between its lowest and its highest one there.
  Expected<double> distance_px(const glm::dvec3& p, double depth_m, double surface_z_m) const {
    const double pixel_m = depth_m / camera_.focal_px();
    double low = surface_z_m;
    double high = surface_z_m;
    double nearest_px = std::abs(p.z - surface_z_m) / pixel_m;
    for (int ring = 1; ring <= kRings; ++ring) {
      const double radius_m = report_.limit_px * pixel_m * ring / kRings;
      for (int k = 0; k < kRingPoints; ++k) {
        const double angle = 2 * std::numbers::pi * k / kRingPoints;
        const glm::dvec3 q = p + radius_m * glm::dvec3(std::cos(angle), std::sin(angle), 0);
        const auto z = rays_.height(column(q), row(q));
        if (!z) return tl::unexpected(z.error());
        if (std::isnan(*z)) continue;
        low = std::min(low, *z);
        high = std::max(high, *z);
      }
      const double aside_m = std::max({0.0, low - p.z, p.z - high});
      nearest_px = std::min(nearest_px, std::hypot(radius_m, aside_m) / pixel_m);
    }
    return nearest_px;
  }

  /// Whether the surface has the drawn depth within the reach of this pixel.
  bool near_surface_depth(int x, int y) const {
    double low = kMiss;
    double high = 0;
    const double depth = drawn_.bare_depths_m[index(x, y)];
    for_neighbours(x, y, [&](std::size_t i) {
      if (surface_m_[i] == kMiss) return;
      low = std::min(low, surface_m_[i]);
      high = std::max(high, surface_m_[i]);
    });
    // A jump of depth, or the same place.
    return high > low * 1.02 && depth >= low * (1 - kDepthTolerance) && depth <= high * (1 + kDepthTolerance);
  }

  template <typename Visit>
  void for_neighbours(int x, int y, const Visit& visit) const {
    for (int j = std::max(y - reach_, 0); j <= std::min(y + reach_, height_ - 1); ++j) {
      for (int i = std::max(x - reach_, 0); i <= std::min(x + reach_, width_ - 1); ++i) visit(index(i, j));
    }
  }

  void summarise_shifts() {
    double squares = 0;
    report_.shifts = app::RgbImage(width_, height_);
    for (std::size_t i = 0; i < shifts_px_.size(); ++i) {
      const double shift = shifts_px_[i];
      std::ranges::copy(error_color(shift / report_.limit_px), report_.shifts.rgb.data() + 3 * i);
      if (std::isnan(shift)) continue;
      report_.shift_max_px = std::max(report_.shift_max_px, shift);
      squares += shift * shift;
    }
    const auto seen = static_cast<double>(std::max<std::uint64_t>(report_.terrain_px, 1));
    report_.shift_rms_px = std::sqrt(squares / seen);
  }

  /// Background where the surface is seen, and terrain where it is not, each more than the reach from where the
  /// other one could be.
  std::optional<Error> compare_outline_row(int y, OutlineCounts& counts) const {
    for (int x = 0; x < width_; ++x) {
      const bool terrain = drawn_.depths_m[index(x, y)] != kMiss;
      bool same = false;
      for_neighbours(x, y, [&](std::size_t i) { same = same || (surface_m_[i] != kMiss) == terrain; });
      if (same) continue;
      auto near = between_pixels(x, y, terrain);
      if (near && !*near && !terrain) near = over_hole(x, y);
      if (!near) return near.error();
      if (*near) continue;
      ++(terrain ? counts.silhouette_px : counts.crack_px);
    }
    return std::nullopt;
  }

  /// Whether the ground seen within the reach of a pixel has a hole, however small: cell by cell.
  Expected<bool> over_hole(int x, int y) const {
    std::array<double, 2> low{kMiss, kMiss};
    std::array<double, 2> high{-kMiss, -kMiss};
    for_neighbours(x, y, [&](std::size_t i) {
      const glm::dvec3 p = point(i, surface_m_[i]);
      low = {std::min(low[0], column(p)), std::min(low[1], row(p))};
      high = {std::max(high[0], column(p)), std::max(high[1], row(p))};
    });
    // Ground that is hidden, or farther apart than this, says nothing about the pixel.
    if ((high[0] - low[0]) * (high[1] - low[1]) > kMostCells) return false;
    for (double r = std::floor(low[1]) - 1; r <= high[1] + 1; ++r) {
      for (double c = std::floor(low[0]) - 1; c <= high[0] + 1; ++c) {
        for (const auto& [u, v] : {std::pair(0.3, 0.6), std::pair(0.6, 0.3)}) {
          const auto z = rays_.height(c + u, r + v);
          if (!z) return tl::unexpected(z.error());
          if (std::isnan(*z)) return true;
        }
      }
    }
    return false;
  }

  /// Whether the surface is seen (`terrain`), or not, anywhere within the reach of a pixel: a ridge may be narrower
  /// than the distance of pixels.
  Expected<bool> between_pixels(int x, int y, bool terrain) const {
    const int steps = kSubPixels * reach_;
    for (int j = -steps; j <= steps; ++j) {
      for (int i = -steps; i <= steps; ++i) {
        const glm::dvec3 d =
            camera_.ray(x + 0.5 + static_cast<double>(i) / kSubPixels, y + 0.5 + static_cast<double>(j) / kSubPixels);
        const auto hit = rays_.cast(grid_ray(d));
        if (!hit) return tl::unexpected(hit.error());
        if ((*hit != kMiss) == terrain) return true;
      }
    }
    return false;
  }

  const codec::TreeLayout& layout_;
  const AuditContext& context_;
  const SurfaceRays& rays_;
  const DrawnView& drawn_;
  const render::Camera& camera_;
  const Screen screen_;
  int width_;
  int height_;
  int reach_ = 1;                  ///< Pixels that an outline may be off.
  std::vector<double> surface_m_;  ///< Depth of the surface at each pixel, or kMiss.
  std::vector<double> shifts_px_;  ///< NaN where no surface is seen.
  std::unordered_map<std::int64_t, std::vector<std::size_t>> drawn_tiles_;  ///< Pixels by tile key.
  std::mutex turn_;  ///< Guards the error and the largest distance.
  std::optional<Error> error_;
  ViewReport report_;
};

}  // namespace

Expected<ViewReport> compare_view(const AuditContext& context, const SurfaceRays& rays, const DrawnView& drawn,
                                  double pixel_error) {
  return Comparison(context, rays, drawn, pixel_error).run();
}

}  // namespace tintree::audit
