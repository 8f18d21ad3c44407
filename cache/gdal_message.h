#pragma once

#include <string>

namespace tintree::cache {

/// What GDAL said last in this thread, for our own messages; that it said nothing where it did not.
std::string last_gdal_message();

}  // namespace tintree::cache
