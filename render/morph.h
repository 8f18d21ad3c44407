#pragma once

#include <cstdint>

#include "cache/tile_bounds.h"
#include "render/screen_error.h"

namespace tintree::render {

/// How far, 0 to 1, a node's tile is to be on its way to its parent's surface, so that neither the change to the
/// parent nor that to its children shows (geomorphs: Schneider and Westermann 2006, section 5; one weight a tile
/// here, because tiles that are larger than their distance leave no room for one a vertex).
///
/// With e the largest error of the node and its siblings, E that of the parent, and t the error that counts
/// `pixel_error` in the *parent's* box at the rate at which E counts (ScreenError), the weight is (t - e) / (E - e): 1
/// where the parent may be drawn in their place, 0 before any of them gives way to its children, the same for all four.
/// The error of the surface in between is then t: what the pixel allows. 0 for the root. `node`: index into nodes().
/// Cost: about 0.2 us.
double morph_weight(const cache::TileBounds& bounds, std::uint32_t node, const ScreenError& screen_error,
                    double pixel_error);

/// The node above one that is not the root.
const cache::TileNode& parent_of(const cache::TileBounds& bounds, const cache::TileNode& node);
/// The most, metres, that a tile's surface and its parent's can be apart; 0 for the root.
double farthest_morph_m(const cache::TileBounds& bounds, const cache::TileNode& node);
/// The box of all that may be drawn of a node on its way to its parent, and of the tiles below it on theirs.
cache::Box morph_box(const cache::TileBounds& bounds, const cache::TileNode& node);

}  // namespace tintree::render
