#pragma once

#include <span>
#include <string>
#include <string_view>

#include "codec/error.h"

namespace tintree::app {

/// The folder that the path lies in, "." if it names none.
std::string folder_of(const std::string& path);

/// Fails with kIo where `path` could not be written later on: refuses before hours of work what would fail after them.
/// Fails with kUsage where it is one of the files that are read, under whatever name: it would be lost.
Expected<void> check_output_file(const std::string& path, std::span<const std::string> inputs = {});

/// Writes `bytes` to `path` by way of a temporary file, so that a reader sees either the old file or the whole
/// new one; straight to a device or pipe. Fails with kIo.
Expected<void> write_whole_file(const std::string& path, std::string_view bytes);

}  // namespace tintree::app
