#pragma once

#include "render/camera.h"
#include "render/lod_cut.h"

namespace tintree::render {

/// A cut that was chosen for another camera, to be drawn from this one: the same tiles with their depths as this
/// camera sees them. Errors stay those of the camera it was chosen for.
LodCut seen_from(LodCut cut, Trees trees, const Camera& camera);

}  // namespace tintree::render
