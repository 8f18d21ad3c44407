#pragma once

#include <chrono>

#include "apps/view/view_options.h"
#include "codec/error.h"
#include "render/terrain_scene.h"

namespace tintree::view {

/// Shows a tree in a window until it is closed: drag with the left button to orbit, with the right or middle
/// one to pan, wheel to zoom to the cursor, WASD or arrows to move, R or Home for the first view, F to see
/// the triangles, F12 for a picture, Esc to quit. With options.screenshot it writes that picture instead and
/// shows nothing. Fails with kIo when there is no display.
Expected<void> run_window(render::TerrainScene::Stores stores, const ViewOptions& options,
                          std::chrono::steady_clock::time_point begun);

}  // namespace tintree::view
