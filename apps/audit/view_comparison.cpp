#include "apps/audit/view_comparison.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>

#include <tbb/parallel_for.h>

#include "apps/audit/color_scale.h"
#include "apps/audit/drawn_mesh_rays.h"
#include "apps/audit/drawn_points.h"
#include "apps/audit/mesh_heights.h"
#include "apps/audit/outlines.h"
#include "apps/audit/view_frame.h"

namespace tintree::audit {
namespace {

constexpr double kMiss = SurfaceRays::kMiss;

class Comparison {
 public:
  Comparison(const AuditContext& context, const SurfaceRays& rays, const DrawnView& drawn, double pixel_error)
      : layout_(context.store.manifest().layout),
        context_(context),
        rays_(rays),
        drawn_(drawn),
        frame_(layout_, drawn.camera, std::max(pixel_error, drawn.cut.max_error_px)),
        surface_m_(frame_.pixels(), kMiss),
        shifts_px_(frame_.pixels(), std::numeric_limits<double>::quiet_NaN()) {
    report_.limit_px = frame_.limit_px();
    for (const render::DrawTile& d : drawn.cut.draws) {
      drawn_tiles_.emplace(context.store.bounds().nodes()[d.node].id.key(), std::vector<std::size_t>());
    }
  }

  Expected<ViewReport> run() {
    if (const auto error = frame_.each_row([this](int y) { return cast_row(y); })) return tl::unexpected(*error);
    file_pixels();
    if (const auto error = compare_tiles()) return tl::unexpected(*error);
    const SeenSurface seen{frame_, rays_, surface_m_};
    const auto points = compare_drawn_points(seen, drawn_.bare_depths_m, drawn_meshes());
    if (!points) return tl::unexpected(points.error());
    report_.drawn_max_px = points->max_px;
    report_.amiss_px = points->amiss_px;
    const auto outlines = compare_outlines(seen, drawn_.depths_m);
    if (!outlines) return tl::unexpected(outlines.error());
    report_.crack_px = outlines->crack_px;
    report_.silhouette_px = outlines->silhouette_px;
    summarise_shifts();
    return std::move(report_);
  }

 private:
  std::function<Expected<DrawnMeshRays>()> drawn_meshes() const {
    if (!drawn_.as_stored) return nullptr;
    return [this] { return DrawnMeshRays::read(context_.store, drawn_.cut, drawn_.camera.eye); };
  }

  /// Where the surface is seen, as depths along the view.
  std::optional<Error> cast_row(int y) {
    for (int x = 0; x < drawn_.camera.width_px; ++x) {
      const std::size_t i = frame_.index(x, y);
      const auto hit = rays_.cast(frame_.grid_ray(frame_.ray(i)));
      if (!hit) return hit.error();
      surface_m_[i] = *hit;
    }
    return std::nullopt;
  }

  /// Files every pixel under the drawn tile that holds its surface point.
  void file_pixels() {
    for (std::size_t i = 0; i < surface_m_.size(); ++i) {
      if (surface_m_[i] == kMiss) continue;
      ++report_.terrain_px;
      const glm::dvec3 p = frame_.point(i, surface_m_[i]);
      const double last_column = static_cast<double>(layout_.columns - 2);
      const double last_row = static_cast<double>(layout_.rows - 2);
      const auto c = static_cast<std::int64_t>(std::clamp(frame_.column(p), 0.0, last_column));
      const auto r = static_cast<std::int64_t>(std::clamp(frame_.row(p), 0.0, last_row));
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

  std::optional<Error> compare_tiles() {
    std::vector<std::pair<codec::TileId, const std::vector<std::size_t>*>> tiles;
    for (const auto& [key, pixels] : drawn_tiles_) tiles.emplace_back(codec::TileId::from_key(key), &pixels);
    std::optional<Error> error;
    tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t i) {
      const auto largest_px = compare_tile(tiles[i].first, *tiles[i].second);
      const std::scoped_lock lock(turn_);
      if (largest_px) {
        report_.distance_max_px = std::max(report_.distance_max_px, *largest_px);
      } else if (!error) {
        error = largest_px.error();
      }
    });
    return error;
  }

  /// Sets the shifts of a tile's pixels and returns the largest distance.
  Expected<double> compare_tile(const codec::TileId& id, const std::vector<std::size_t>& pixels) {
    if (pixels.empty()) return 0;
    auto mesh = context_.store.read_mesh(id);
    if (!mesh) return tl::unexpected(mesh.error());
    const TileSurface surface = place(layout_, id, std::move(*mesh));
    const MeshHeights heights(surface);
    double largest_px = 0;
    for (const std::size_t i : pixels) {
      const glm::dvec3 p = frame_.point(i, surface_m_[i]);
      const double z = heights.at(frame_.column(p), frame_.row(p));
      shifts_px_[i] = std::isnan(z) ? kMiss : frame_.distance_px(p, {p.x, p.y, z});
      const double distance_px = std::isnan(z) ? kMiss : std::abs(z - p.z) / frame_.footprint_m(surface_m_[i]);
      largest_px = std::max(largest_px, distance_px);
    }
    return largest_px;
  }

  void summarise_shifts() {
    double squares = 0;
    report_.shifts = app::RgbImage(drawn_.camera.width_px, drawn_.camera.height_px);
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

  const codec::TreeLayout& layout_;
  const AuditContext& context_;
  const SurfaceRays& rays_;
  const DrawnView& drawn_;
  const ViewFrame frame_;
  std::vector<double> surface_m_;  ///< Depth of the surface at each pixel, or kMiss.
  std::vector<double> shifts_px_;  ///< NaN where no surface is seen.
  std::unordered_map<std::int64_t, std::vector<std::size_t>> drawn_tiles_;  ///< Pixels by tile key.
  std::mutex turn_;  ///< Guards the largest distance and an error.
  ViewReport report_;
};

}  // namespace

Expected<ViewReport> compare_view(const AuditContext& context, const SurfaceRays& rays, const DrawnView& drawn,
                                  double pixel_error) {
  return Comparison(context, rays, drawn, pixel_error).run();
}

}  // namespace tintree::audit
