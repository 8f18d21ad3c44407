#pragma once

#include <string>
#include <vector>

#include "apps/audit/image_audit.h"
#include "codec/grid_frame.h"
#include "render/camera.h"

namespace tintree::audit {

struct Viewpoint {
  std::string name;
  render::Camera camera;
};

/// Views over the terrain: a flight from corner to corner that comes down and climbs again, looking ahead, and
/// seeded random ones, from level to straight down. All lie so high above `highest_m` that the leaves' bound
/// projects to less than the pixel error.
std::vector<Viewpoint> choose_viewpoints(const codec::TreeLayout& layout, double highest_m,
                                         const ImageOptions& options);

}  // namespace tintree::audit
