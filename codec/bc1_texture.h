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

/// A picture of format kBc1 as one of kRgba8, for cards that cannot read blocks.
PixelArray unpacked(const PixelArray& blocks);

}  // namespace tintree::codec
