#pragma once

#include <string>

#include "apps/audit/tree_audit.h"

namespace tintree::audit {

/// Three pictures of one tile, as data URIs, and the pixel of the largest error in all of them.
struct TilePictures {
  std::string dem;     ///< The DEM, shaded.
  std::string mesh;    ///< The tile's mesh, shaded the same; empty when it cannot be read.
  std::string errors;  ///< The error map.
  int width_px = 0;
  int height_px = 0;
  double peak_x_px = 0;
  double peak_y_px = 0;
};

/// Draws a tile, measuring it once more for the error map.
Expected<TilePictures> draw_tile(const AuditContext& context, const TileFigures& tile, int longest_px);

}  // namespace tintree::audit
