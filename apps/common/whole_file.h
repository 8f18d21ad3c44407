#pragma once

#include <string>
#include <string_view>

#include "codec/error.h"

namespace tintree::app {

/// Writes `bytes` to `path` by way of a temporary file, so that a reader sees either the old file or the whole
/// new one. Fails with kIo.
Expected<void> write_whole_file(const std::string& path, std::string_view bytes);

}  // namespace tintree::app
