#pragma once

#include <chrono>

#include "apps/view/view_options.h"
#include "cache/tile_store.h"
#include "codec/error.h"
#include "render/gl_functions.h"

namespace tintree::view {

/// Draws one picture once all its tiles are there; writes it and the figures where the options say.
/// `begun`: since when `seconds` count. The context of `gl` is current.
Expected<void> draw_still(const render::GlFunctions& gl, const cache::TileStore& store, const ViewOptions& options,
                          std::chrono::steady_clock::time_point begun);

}  // namespace tintree::view
