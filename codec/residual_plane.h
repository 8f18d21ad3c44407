#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/error.h"
#include "codec/jpeg2000_plane.h"
#include "codec/patch.h"

namespace tintree::codec {

/// Bits of a quantised residual at most.
inline constexpr int kMostBits = 16;

/// The quantiser: residual = low + step * number, number in 0 .. 2^bits - 1.
struct Quantizer {
  std::int64_t low = 0;
  std::int64_t step = 1;
  int bits = 0;  ///< 0: all numbers are 0 and no plane follows.
};

/// The prediction and what the plane says beyond it; without samples, all numbers are 0.
Patch dequantized(const Patch& prediction, const Quantizer& quantizer, const Plane& plane);

/// The bytes of a patch as the paper has it (Yusov & Turlapov 2008, section 3.4): the quantiser, and the plane's code
/// stream unless there are no bits.
std::vector<std::byte> residual_bytes(const Quantizer& quantizer, std::span<const std::byte> stream);

/// Reads what follows the number of bits, 0 to kMostBits, and drops it from `bytes`. kBadData for what is none; heights
/// may be out of range then.
Expected<Patch> take_residuals(std::span<const std::byte>& bytes, int bits, const Patch& prediction);

}  // namespace tintree::codec
