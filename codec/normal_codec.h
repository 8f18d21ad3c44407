#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "codec/error.h"
#include "codec/node_image.h"
#include "codec/texture_codec.h"

namespace tintree::codec {

/// Payloads of table `normal` (docs/format.md): the direction of every mean normal as BC5, and, unless all are unit
/// vectors, their lengths as BC4. Both are drawn as they are stored. Stateless functions, any thread.

/// Deterministic.
std::vector<std::byte> encode_normals(const NormalImage& image);
/// kBadData when the bytes are no normal map of `size` x `size` texels.
Expected<NormalImage> decode_normals(std::span<const std::byte> payload, int size);

/// The same as a graphics card takes it.
struct NormalPixels {
  PixelArray directions;
  PixelArray lengths;  ///< Of size 0 when all are 1.
};
Expected<NormalPixels> normal_pixels(std::span<const std::byte> payload, int size);

}  // namespace tintree::codec
