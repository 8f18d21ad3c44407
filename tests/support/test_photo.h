#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "tests/support/test_raster.h"

namespace tintree::test {

/// Red, green, blue and alpha of the pixel at (column, row).
using PhotoFunction = std::function<std::array<std::uint8_t, 4>(int column, int row)>;

/// Writes a GeoTIFF of 8-bit bands, three or, with `alpha`, four; size, place and CRS as of a raster. Throws
/// std::runtime_error when GDAL cannot.
void write_photo(const std::string& path, const RasterSpec& spec, bool alpha, const PhotoFunction& color);

/// A smooth photo with much contrast, opaque.
std::array<std::uint8_t, 4> meadow(int column, int row);

}  // namespace tintree::test
