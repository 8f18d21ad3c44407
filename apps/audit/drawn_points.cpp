#include "apps/audit/drawn_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace tintree::audit {
namespace {

constexpr double kMiss = SurfaceRays::kMiss;
/// Depths this near each other, as shares, are one: the driver places vertices on a lattice of its own.
constexpr double kDepthTolerance = 2e-3;
/// Rings on which the surface is looked at round a drawn point.
constexpr int kRings = 8;
constexpr int kRingPoints = 24;
/// Of so many pixels one may be drawn amiss.
constexpr std::size_t kPixelsPerAmiss = 10000;

/// A pixel whose point is off by more than the limit.
struct Suspect {
  int x = 0;
  int y = 0;
  double off_px = 0;
};

class DrawnComparison {
 public:
  DrawnComparison(const SeenSurface& seen, std::span<const double> drawn_m)
      : frame_(seen.frame), seen_(seen), drawn_m_(drawn_m) {}

  Expected<DrawnPoints> run(const std::function<Expected<DrawnMeshRays>()>& meshes) {
    const auto rows = static_cast<std::size_t>(frame_.camera().height_px);
    std::vector<double> largest_px(rows, 0);
    std::vector<std::vector<Suspect>> suspects(rows);
    const auto error = frame_.each_row([&](int y) {
      const auto row = static_cast<std::size_t>(y);
      return compare_row(y, largest_px[row], suspects[row]);
    });
    if (error) return tl::unexpected(*error);
    DrawnPoints out{std::ranges::max(largest_px), 0};
    std::vector<Suspect> all;
    for (const auto& row : suspects) all.insert(all.end(), row.begin(), row.end());
    if (meshes && !all.empty() && all.size() <= std::max<std::size_t>(1, drawn_m_.size() / kPixelsPerAmiss)) {
      if (auto done = judge_exactly(all, meshes, out); !done) return tl::unexpected(done.error());
    }
    for (const Suspect& s : all) out.max_px = std::max(out.max_px, s.off_px);
    return out;
  }

 private:
  std::optional<Error> compare_row(int y, double& largest_px, std::vector<Suspect>& suspects) const {
    for (int x = 0; x < frame_.camera().width_px; ++x) {
      const double depth_m = drawn_m_[frame_.index(x, y)];
      if (depth_m == kMiss) continue;
      const auto off_px = off(x, y, depth_m);
      if (!off_px) return off_px.error();
      if (*off_px > frame_.limit_px() + kDriverPx) {
        suspects.push_back({x, y, *off_px});
      } else {
        largest_px = std::max(largest_px, *off_px);
      }
    }
    return std::nullopt;
  }

  /// Replaces what the driver drew amiss.
  Expected<void> judge_exactly(std::vector<Suspect>& suspects, const std::function<Expected<DrawnMeshRays>()>& read,
                               DrawnPoints& out) const {
    const auto meshes = read();
    if (!meshes) return tl::unexpected(meshes.error());
    for (Suspect& s : suspects) {
      const std::size_t i = frame_.index(s.x, s.y);
      const double drawn_m = drawn_m_[i];
      if (meshes->distance_m(frame_.point(i, drawn_m)) <= kDriverPx * frame_.footprint_m(drawn_m)) continue;
      const double exact_m = meshes->cast(frame_.ray(i));
      if (exact_m == kMiss) continue;
      const auto off_px = off(s.x, s.y, exact_m);
      if (!off_px) return tl::unexpected(off_px.error());
      s.off_px = *off_px;
      ++out.amiss_px;
    }
    return {};
  }

  /// How far a pixel's point at this depth is from the surface.
  Expected<double> off(int x, int y, double depth_m) const {
    if (near_surface_depth(x, y, depth_m)) return 0;
    const glm::dvec3 p = frame_.point(frame_.index(x, y), depth_m);
    const auto z = seen_.rays.height(frame_.column(p), frame_.row(p));
    if (!z) return z;
    // Where the surface has an end or a hole, outlines are compared.
    if (std::isnan(*z)) return 0;
    const double off_px = frame_.distance_px(p, {p.x, p.y, *z});
    if (off_px <= frame_.limit_px()) return off_px;
    const auto aside_px = distance_px(p, depth_m, *z);
    return aside_px ? std::min(off_px, *aside_px) : aside_px;
  }

  /// At most how far a point is from the surface in any direction, in pixels of its depth: on walls the surface
  /// straight above or below is not the nearest one. The surface is without gaps, so over a disc it has every
  /// height between its lowest and its highest one there.
  Expected<double> distance_px(const glm::dvec3& p, double depth_m, double surface_z_m) const {
    const double pixel_m = frame_.footprint_m(depth_m);
    double low = surface_z_m;
    double high = surface_z_m;
    double nearest_px = std::abs(p.z - surface_z_m) / pixel_m;
    for (int ring = 1; ring <= kRings; ++ring) {
      const double radius_m = frame_.limit_px() * pixel_m * ring / kRings;
      for (int k = 0; k < kRingPoints; ++k) {
        const double angle = 2 * std::numbers::pi * k / kRingPoints;
        const glm::dvec3 q = p + radius_m * glm::dvec3(std::cos(angle), std::sin(angle), 0);
        const auto z = seen_.rays.height(frame_.column(q), frame_.row(q));
        if (!z) return z;
        if (std::isnan(*z)) continue;
        low = std::min(low, *z);
        high = std::max(high, *z);
      }
      const double aside_m = std::max({0.0, low - p.z, p.z - high});
      nearest_px = std::min(nearest_px, std::hypot(radius_m, aside_m) / pixel_m);
    }
    return nearest_px;
  }

  /// Whether depth jumps within the reach of a pixel, and the surface has this depth there.
  bool near_surface_depth(int x, int y, double depth_m) const {
    double low = kMiss;
    double high = 0;
    frame_.for_near(x, y, [&](std::size_t i) {
      if (seen_.depths_m[i] == kMiss) return;
      low = std::min(low, seen_.depths_m[i]);
      high = std::max(high, seen_.depths_m[i]);
    });
    return high > low * 1.02 && depth_m >= low * (1 - kDepthTolerance) && depth_m <= high * (1 + kDepthTolerance);
  }

  const ViewFrame& frame_;
  const SeenSurface& seen_;
  std::span<const double> drawn_m_;
};

}  // namespace

Expected<DrawnPoints> compare_drawn_points(const SeenSurface& seen, std::span<const double> drawn_m,
                                           const std::function<Expected<DrawnMeshRays>()>& meshes) {
  return DrawnComparison(seen, drawn_m).run(meshes);
}

}  // namespace tintree::audit
