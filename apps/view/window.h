#pragma once

#include <chrono>
#include <optional>

#include "apps/view/view_options.h"
#include "codec/error.h"
#include "render/flight.h"
#include "render/terrain_scene.h"

namespace tintree::view {

/// Shows trees in a window until it is closed (controls.h), then writes options.json. With options.screenshot it
/// writes that picture instead and shows nothing. `flight`: to play at the beginning. Fails with kIo when there is no
/// display.
Expected<void> run_window(render::TerrainScene::Stores stores, const ViewOptions& options,
                          std::optional<render::Flight> flight, std::chrono::steady_clock::time_point begun);

}  // namespace tintree::view
