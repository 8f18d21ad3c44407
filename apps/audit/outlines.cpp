#include "apps/audit/outlines.h"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace tintree::audit {
namespace {

constexpr double kMiss = SurfaceRays::kMiss;
/// Rays a pixel's width, where outlines are looked for between pixels.
constexpr int kSubPixels = 4;
constexpr double kMostCells = 65536;

/// Whether the surface is seen (`terrain`), or not, anywhere within the reach of a pixel: a ridge may be narrower
/// than the distance of pixels.
Expected<bool> between_pixels(const SeenSurface& seen, int x, int y, bool terrain) {
  const int steps = kSubPixels * seen.frame.reach();
  for (int j = -steps; j <= steps; ++j) {
    for (int i = -steps; i <= steps; ++i) {
      const glm::dvec3 ray = seen.frame.camera().ray(x + 0.5 + static_cast<double>(i) / kSubPixels,
                                                     y + 0.5 + static_cast<double>(j) / kSubPixels);
      const auto hit = seen.rays.cast(seen.frame.grid_ray(ray));
      if (!hit) return tl::unexpected(hit.error());
      if ((*hit != kMiss) == terrain) return true;
    }
  }
  return false;
}

/// Whether the ground seen within the reach of a pixel has a hole, however small: cell by cell.
Expected<bool> over_hole(const SeenSurface& seen, int x, int y) {
  const ViewFrame& frame = seen.frame;
  std::array<double, 2> low{kMiss, kMiss};
  std::array<double, 2> high{-kMiss, -kMiss};
  frame.for_near(x, y, [&](std::size_t i) {
    const glm::dvec3 p = frame.point(i, seen.depths_m[i]);
    low = {std::min(low[0], frame.column(p)), std::min(low[1], frame.row(p))};
    high = {std::max(high[0], frame.column(p)), std::max(high[1], frame.row(p))};
  });
  // Ground that is hidden, or farther apart than this, says nothing about the pixel.
  if ((high[0] - low[0]) * (high[1] - low[1]) > kMostCells) return false;
  for (double r = std::floor(low[1]) - 1; r <= high[1] + 1; ++r) {
    for (double c = std::floor(low[0]) - 1; c <= high[0] + 1; ++c) {
      for (const auto& [u, v] : {std::pair(0.3, 0.6), std::pair(0.6, 0.3)}) {
        const auto z = seen.rays.height(c + u, r + v);
        if (!z) return tl::unexpected(z.error());
        if (std::isnan(*z)) return true;
      }
    }
  }
  return false;
}

std::optional<Error> compare_row(const SeenSurface& seen, std::span<const double> drawn_m, int y,
                                 OutlineCounts& counts) {
  for (int x = 0; x < seen.frame.camera().width_px; ++x) {
    const bool terrain = drawn_m[seen.frame.index(x, y)] != kMiss;
    bool same = false;
    seen.frame.for_near(x, y, [&](std::size_t i) { same = same || (seen.depths_m[i] != kMiss) == terrain; });
    if (same) continue;
    auto near = between_pixels(seen, x, y, terrain);
    if (near && !*near && !terrain) near = over_hole(seen, x, y);
    if (!near) return near.error();
    if (*near) continue;
    ++(terrain ? counts.silhouette_px : counts.crack_px);
  }
  return std::nullopt;
}

}  // namespace

Expected<OutlineCounts> compare_outlines(const SeenSurface& seen, std::span<const double> drawn_m) {
  std::vector<OutlineCounts> rows(static_cast<std::size_t>(seen.frame.camera().height_px));
  const auto error =
      seen.frame.each_row([&](int y) { return compare_row(seen, drawn_m, y, rows[static_cast<std::size_t>(y)]); });
  if (error) return tl::unexpected(*error);
  OutlineCounts sum;
  for (const OutlineCounts& row : rows) {
    sum.crack_px += row.crack_px;
    sum.silhouette_px += row.silhouette_px;
  }
  return sum;
}

}  // namespace tintree::audit
