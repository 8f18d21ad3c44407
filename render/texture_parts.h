#pragma once

#include <functional>

#include "cache/tile_ref.h"
#include "render/camera.h"
#include "render/lod_cut.h"

namespace tintree::render {

/// What is known of the texture on a square in a leaf.
enum class TextureState {
  kMissing,
  kResident,
  kNone,  ///< No photo is finer there.
  kLost,  ///< It will never come: its bytes are damaged.
};
using TextureStates = std::function<TextureState(const cache::TileRef& square)>;

/// Looks for the textures that a cut's leaves want, in trees whose photos are finer than their leaves
/// (TileBounds::texture_depth()): of their quadrants, and those' quadrants, as far as they are in view and the texels
/// of the square round them are too large for CutOptions::texel_px. What is resident is added to the cut's parts, what
/// is missing to its requests, behind its own: the coarsest first, then those nearest to the view's middle. Pure. Cost:
/// as lod_cut()'s.
void add_texture_parts(LodCut& cut, Trees trees, const Camera& camera, const TextureStates& states);

}  // namespace tintree::render
