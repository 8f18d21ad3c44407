#pragma once

#include "codec/texture_codec.h"

namespace tintree::codec {

/// Texture codec `jpeg`: smaller on disk than `bc1`, eight times as large on the card, and decoded on the processor.
class JpegTexture final : public TextureCodec {
 public:
  Expected<std::vector<std::byte>> encode(const ColorImage& image) const override;
  Expected<ColorImage> decode(std::span<const std::byte> payload, int size) const override;
  Expected<PixelArray> pixels(std::span<const std::byte> payload, int size) const override;
};

}  // namespace tintree::codec
