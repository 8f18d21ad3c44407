#pragma once

#include <vector>

#include "cache/nested_shape_packing.h"

namespace tintree::cache {

/// Of a tile without a parent, whose points have the levels and heights of its payload's own meshes: puts in place of
/// each level the coarsest of them that is sure to keep that level's bound. `bound_steps`: the bound of the tile's
/// level, `error_steps`: its measured error, both in its height steps. The five points that come first stay on level 0.
void choose_own_levels(std::vector<NestedShapePoint>& points, double bound_steps, double error_steps);

}  // namespace tintree::cache
