#include "apps/view/places.h"

#include <cmath>

#include <fmt/format.h>

namespace tintree::view {

std::array<double, 2> crs_coordinates(const cache::Manifest& manifest, const glm::dvec3& world_m) {
  const auto [column, row] = manifest.layout.grid(world_m.x, world_m.y);
  // The transform counts from pixel corners, the grid from their centres.
  const double c = column + 0.5;
  const double r = row + 0.5;
  const auto& t = manifest.geotransform;
  return {t[0] + c * t[1] + r * t[2], t[3] + c * t[4] + r * t[5]};
}

std::string place_text(const cache::Manifest& manifest, const glm::dvec3& world_m) {
  const auto [x, y] = crs_coordinates(manifest, world_m);
  const std::string world = fmt::format("x {:.1f} y {:.1f} height {:.1f} m", world_m.x, world_m.y, world_m.z);
  if (!manifest.geographic) return fmt::format("{} · CRS {:.2f}, {:.2f}", world, x, y);
  return fmt::format("{} · {:.6f}°{} {:.6f}°{}", world, std::abs(y), y < 0 ? 'S' : 'N', std::abs(x), x < 0 ? 'W' : 'E');
}

}  // namespace tintree::view
