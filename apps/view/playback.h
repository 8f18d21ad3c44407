#pragma once

#include "apps/view/view_options.h"
#include "codec/error.h"
#include "render/flight.h"
#include "render/gl_functions.h"
#include "render/terrain_scene.h"

namespace tintree::view {

/// Plays a flight without a window and writes frames and figures where they say (docs/guide.md, Flights).
/// With --frames every frame waits for its tiles, so that the pictures are the same on every run; without,
/// no frame waits, as in a window. The context of `gl` is current.
Expected<void> play_flight(const render::GlFunctions& gl, render::TerrainScene::Stores stores,
                           const render::Flight& flight, const ViewOptions& options);

}  // namespace tintree::view
