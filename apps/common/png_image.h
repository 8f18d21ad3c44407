#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codec/error.h"

namespace tintree::app {

/// 8-bit RGB pixels of the web's colour space, row-major, the upper row first.
struct RgbImage {
  explicit RgbImage(int width = 0, int height = 0)
      : width_px(width),
        height_px(height),
        rgb(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0) {}

  std::uint8_t* at(int x_px, int y_px) {
    return rgb.data() + 3 * (static_cast<std::ptrdiff_t>(y_px) * width_px + x_px);
  }

  int width_px;
  int height_px;
  std::vector<std::uint8_t> rgb;
};

/// The pixels as the bytes of a PNG file; `rgb` holds 3 * width_px * height_px values. Fails with kIo.
Expected<std::string> encode_png(int width_px, int height_px, std::span<const std::uint8_t> rgb);

/// The image as a "data:image/png;base64,..." address, for pages that carry their pictures.
Expected<std::string> png_data_uri(const RgbImage& image);

}  // namespace tintree::app
