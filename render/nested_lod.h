#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cache/nested_shape.h"
#include "render/lod_cut.h"
#include "render/screen_error.h"

namespace tintree::render {

/// The nested level of detail (Schneider and Westermann 2006, section 5) where an error of so many bounds of a tile's
/// level is allowed, a real number: 8, the tile's own mesh, up to one bound; 8 - i at 2^i bounds, where the paper's
/// logarithm is; linear in the error between these, as the surface between two meshes is. The vertex shader does the
/// same, vertex by vertex from its own depth (the paper: from the corners of the tile's box), so that two tiles that
/// show a place, side by side or one after the other, agree on its level.
float level_for(float bounds);

/// The least level that all of a box can be drawn by: level i of a tile is within 2^(8 - i) times `bound_m`.
int mesh_level(const ScreenError& screen_error, const cache::Box& box, double bound_m, double pixel_error);

/// Weights of the heights on levels 0 to 8 of a vertex at this level: forward differences of the clamped ramps
/// clamp(level - i, 0, 1), the piecewise linear basis (section 5, Geomorphing). They add up to 1. The vertex shader
/// does the same.
std::array<float, cache::NestedShape::kLevels> morph_weights(float level);

/// How far a tile is drawn off its own mesh, level 8, vertically: by less than so many times what the pixel error
/// measures at the distance. For a coarser level and any between are off the DEM by as much at most, and level 8, where
/// another is drawn, by half of that.
inline constexpr double kNestedOff = 2;

/// Sets DrawTile::nested_level of the tiles of trees that are `nested` (not 0), and what is drawn of them by a coarser
/// level than their own counts for that level's error.
void choose_nested_levels(Trees trees, const Camera& camera, std::span<const std::uint8_t> nested, LodCut& cut);

}  // namespace tintree::render
