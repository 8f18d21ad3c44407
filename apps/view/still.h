#pragma once

#include <chrono>

#include "apps/view/view_options.h"
#include "codec/error.h"
#include "render/gl_functions.h"
#include "render/terrain_scene.h"

namespace tintree::view {

/// Draws one picture once all its tiles are there; writes it and the figures where the options say.
/// `begun`: since when `seconds` count. The context of `gl` is current.
Expected<void> draw_still(const render::GlFunctions& gl, render::TerrainScene::Stores stores,
                          const ViewOptions& options, std::chrono::steady_clock::time_point begun);

}  // namespace tintree::view
