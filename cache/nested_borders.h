#pragma once

#include "cache/drawable_tile.h"
#include "cache/nested_shape.h"

namespace tintree::cache {

/// Lists the vertices on the tile's sides, and on which levels surface joins them. Needs frame, vertices and fans.
/// Cost: one look at each level's triangles.
void add_nested_borders(NestedShape& shape, const TileOutline& outline);

}  // namespace tintree::cache
