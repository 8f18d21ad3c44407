#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "apps/common/png_image.h"

namespace tintree::audit {

/// What one picture drawn from the tree shows beside the full-resolution surface. Distances are on the screen,
/// in pixels.
struct ViewReport {
  std::string name;  ///< "flight 3" or "random 5".
  std::array<double, 3> eye_m{};
  std::array<double, 3> target_m{};
  std::uint64_t tiles = 0;
  std::uint64_t triangles = 0;
  std::uint64_t impostor_tiles = 0;  ///< Further tiles, which an impostor stood in for.
  /// What may be: the pixel error asked for, or more where the view is nearer than the leaves are good for.
  double limit_px = 1;
  /// From the surface's point seen at a pixel to the drawn mesh above or below it.
  double shift_max_px = 0;
  double shift_rms_px = 0;
  /// The same distance in space, over the pixel's footprint there. Seen from above it may exceed the shift.
  double distance_max_px = 0;
  /// From the point drawn at a pixel (the depth buffer's) to the surface above or below it.
  double drawn_max_px = 0;
  std::uint64_t amiss_px = 0;    ///< Pixels that the driver drew amiss; the mesh's exact points there count as drawn.
  std::uint64_t terrain_px = 0;  ///< Pixels at which the surface is seen.
  std::uint64_t crack_px = 0;    ///< Background drawn where the surface is seen, more than a pixel from its outline.
  std::uint64_t silhouette_px = 0;  ///< Terrain drawn more than a pixel outside the surface's outline.
  app::RgbImage picture;            ///< As drawn.
  app::RgbImage shifts;             ///< The first of the shifts, as shares of the limit.
};

struct ImageReport {
  std::string renderer;  ///< The driver's name.
  int width_px = 0;
  int height_px = 0;
  double pixel_error = 1;
  std::vector<ViewReport> views;
  double seconds = 0;
};

}  // namespace tintree::audit
