#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "codec/error.h"

namespace tintree::app {

/// Writes `value` to `path` as indented JSON by way of a temporary file, so that a reader sees either the
/// old file or the whole new one.
Expected<void> write_json(const std::string& path, const nlohmann::ordered_json& value);

/// This process's largest resident set so far, bytes.
std::uint64_t peak_rss_bytes();

}  // namespace tintree::app
