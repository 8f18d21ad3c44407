#pragma once

#include "codec/texture_codec.h"

namespace tintree::codec {

/// Texture codec `bc1`: S3TC blocks (Wahl et al. 2004, section 4, Compression), drawn as they are stored: half a byte a
/// texel on disk and on the card.
class Bc1Texture final : public TextureCodec {
 public:
  Expected<std::vector<std::byte>> encode(const ColorImage& image) const override;
  Expected<ColorImage> decode(std::span<const std::byte> payload, int size) const override;
  Expected<PixelArray> pixels(std::span<const std::byte> payload, int size) const override;
};

/// The texels of `size` x `size` in blocks, as many as blocks_in(size).
ColorImage unpack_bc1(std::span<const std::byte> blocks, int size);

}  // namespace tintree::codec
