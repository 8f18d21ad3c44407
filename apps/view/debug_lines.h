#pragma once

#include <vector>

#include "render/camera.h"
#include "render/line_drawer.h"
#include "render/lod_cut.h"

namespace tintree::view {

/// The boxes of the tiles of a cut: orange where a coarser tile stands in, else blue.
std::vector<render::WorldLine> box_lines(render::Trees trees, const render::LodCut& cut);

/// The camera that a frozen cut was chosen for, as a yellow pyramid down to its target.
std::vector<render::WorldLine> view_lines(const render::Camera& frozen);

}  // namespace tintree::view
