#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "codec/error.h"
#include "codec/node_image.h"

namespace tintree::codec {

/// How the bytes of a picture that is ready for upload are to be read.
enum class PixelFormat : std::uint8_t {
  kRgba8,     ///< 4 bytes a texel: sRGB and alpha.
  kBc1,       ///< Blocks of codec/bc1_block.h: sRGB and one bit of alpha.
  kBc5Snorm,  ///< Two blocks of codec/bc4_block.h each: east and north of unit normals.
  kBc4Snorm,  ///< Blocks of codec/bc4_block.h: lengths of mean normals.
};

/// A picture as a graphics card takes it.
struct PixelArray {
  PixelFormat format = PixelFormat::kRgba8;
  int size = 0;
  std::vector<std::byte> bytes;
};

PixelArray as_pixels(const ColorImage& image);

/// Turns a tile's colours into a payload of table `texture` and back, with a loss (docs/format.md). Stateless: one
/// object serves any number of threads at once.
class TextureCodec {
 public:
  virtual ~TextureCodec() = default;

  /// Deterministic: equal pictures give equal bytes.
  virtual Expected<std::vector<std::byte>> encode(const ColorImage& image) const = 0;
  /// kBadData when the bytes are no picture of `size` x `size` texels.
  virtual Expected<ColorImage> decode(std::span<const std::byte> payload, int size) const = 0;
  /// The payload in the form that takes the least memory on a graphics card without being encoded anew.
  virtual Expected<PixelArray> pixels(std::span<const std::byte> payload, int size) const = 0;
};

/// The codec that the manifest names ("bc1", "jpeg"), or null for one that this version lacks.
const TextureCodec* find_texture_codec(std::string_view name);

}  // namespace tintree::codec
