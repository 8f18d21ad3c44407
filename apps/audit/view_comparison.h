#pragma once

#include <vector>

#include "apps/audit/image_report.h"
#include "apps/audit/surface_rays.h"
#include "apps/audit/tile_audit.h"
#include "render/camera.h"
#include "render/lod_cut.h"

namespace tintree::audit {

/// A picture as a viewer drew it.
struct DrawnView {
  render::Camera camera;
  render::LodCut cut;
  /// Depth along the view at each pixel's centre, metres, row-major from the upper row; infinite where the
  /// background is.
  std::vector<double> depths_m;
  /// The same without skirts, which reach a pixel and a half beyond the meshes.
  std::vector<double> bare_depths_m;
  /// The terrain was drawn as the meshes of the cut's tiles, neither as their nested levels nor as an impostor.
  bool as_stored = false;
};

/// Compares a drawn view with the surface, pixel by pixel, on all cores. Fills in the figures and the picture of
/// the shifts; `name`, `picture` and the counts of what was drawn are the caller's.
///
/// At every pixel the surface's point is found by casting a ray; its counterpart is the point of the drawn tile's
/// mesh straight above or below it, and their distance on the screen is the shift. The other way round the points that
/// were drawn are compared with the surface (drawn_points.h), and so are their outlines (outlines.h).
Expected<ViewReport> compare_view(const AuditContext& context, const SurfaceRays& rays, const DrawnView& drawn,
                                  double pixel_error);

}  // namespace tintree::audit
