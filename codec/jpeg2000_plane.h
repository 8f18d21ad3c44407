#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/error.h"

namespace tintree::codec {

/// One component of whole numbers from 0 to 2^bits - 1, row-major.
struct Plane {
  int width = 0;  ///< 1 to 4100.
  int height = 0;
  int bits = 8;  ///< 1 to 16.
  std::vector<std::int32_t> samples;
};

/// JPEG 2000 (ISO/IEC 15444-1) by OpenJPEG: the reversible 5/3 wavelet, one quality layer, cut off where it is good
/// enough. With it decoding is a matter of integers, the same on every machine, however much was cut off. The code
/// stream comes without its headers, which say the same in all: about 100 bytes less. Cost: 60 ns a sample to encode,
/// 40 to decode what was not cut off.

/// The fewest bytes of which OpenJPEG believes that no more than `loss` gets lost, the root mean square of the samples'
/// differences; it is off by some percent. 0: nothing at all gets lost.
Expected<std::vector<std::byte>> encode_plane(const Plane& plane, double loss);
/// Of the size and the bits that were encoded. kBadData for what is no such stream.
Expected<Plane> decode_plane(std::span<const std::byte> stream, int width, int height, int bits);

}  // namespace tintree::codec
