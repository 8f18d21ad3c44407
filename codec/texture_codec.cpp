#include "codec/texture_codec.h"

#include "codec/bc1_texture.h"
#include "codec/jpeg_texture.h"

namespace tintree::codec {

PixelArray as_pixels(const ColorImage& image) {
  const auto bytes = std::as_bytes(std::span(image.rgba));
  return {PixelFormat::kRgba8, image.size, {bytes.begin(), bytes.end()}};
}

const TextureCodec* find_texture_codec(std::string_view name) {
  static const Bc1Texture bc1;
  static const JpegTexture jpeg;
  if (name == "bc1") return &bc1;
  if (name == "jpeg") return &jpeg;
  return nullptr;
}

}  // namespace tintree::codec
