#pragma once

#include <string>

#include "codec/error.h"
#include "render/offscreen_target.h"

namespace tintree::view {

/// Writes a picture as PNG by way of a temporary file, whatever the name's ending. Fails with kIo.
Expected<void> write_png(const std::string& path, const render::Picture& picture);

}  // namespace tintree::view
