#pragma once

#include <optional>

#include "cache/drawable_tile.h"

namespace tintree::cache {

/// Geomorphs (Schneider and Westermann 2006, section 5) for meshes that share no vertices: the overlay of a tile's
/// triangles with its parent's, in which every vertex has a height on both surfaces. Drawn with the heights of one it
/// is that tile, with those of the other the parent, and at the share w of the way its error is at every point at most
/// (1 - w) times the tile's and w times the parent's. Neighbours agree on their common side at equal shares, because
/// their parents do.
///
/// None when either surface has a hole in the tile's square: then nothing corresponds to it.
/// `parent` is the parent's of `tile`. Cost: about 1 us a triangle; three to five triangles for one of the tile's.
std::optional<MorphMesh> make_morph(const DrawableTile& tile, const DrawableTile& parent);

}  // namespace tintree::cache
