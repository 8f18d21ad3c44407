#pragma once

#include <glm/vec4.hpp>

#include "cache/tile_bounds.h"
#include "render/lod_cut.h"

namespace tintree::render {

/// What the ground's colours tell.
enum class Tint {
  kHeight,  ///< Its height, as a map would.
  kLevel,   ///< The level of each tile.
  kError,   ///< The measured error of each tile as it shows: its share of the pixels allowed.
};

/// sRGB colour (0 to 1) and its strength, under which the ground's own colour shows; strength 0 for kHeight.
/// Levels go round seven hues. Errors run from blue (0) over green (half) to yellow (all of `allowed_px`), then
/// red: more than allowed, where the data end or finer tiles have not come yet.
glm::vec4 tile_tint(Tint tint, const cache::TileNode& node, const DrawTile& drawn, double allowed_px);

}  // namespace tintree::render
