#pragma once

#include <vector>

#include "apps/audit/image_report.h"
#include "apps/audit/tile_audit.h"
#include "apps/audit/violation.h"

namespace tintree::audit {

struct ImageOptions {
  int flight_views = 6;  ///< Along a flight across the terrain, down to where the leaves' error is a pixel.
  int random_views = 6;  ///< From seeded random places.
  int width_px = 640;
  int height_px = 360;
  double pixel_error = 1;
  /// The views are frames of a flight with impostors (render/impostor.h); of so many frames one is compared.
  bool impostors = false;
  int compared_every = 1;
};

/// Draws the tree as a viewer does and compares every pixel with the full-resolution surface, whose points are
/// found by casting rays at the DEM itself. Appends what is wrong to `violations`. Fails with kIo when there is
/// no way to draw, with kUsage in a build without the viewer. Memory: a viewer's, and SurfaceRays'.
/// Deterministic but for what the driver's rounding may change.
Expected<ImageReport> audit_images(const AuditContext& context, const ImageOptions& options,
                                   std::vector<Violation>& violations);

}  // namespace tintree::audit
