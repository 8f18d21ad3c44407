#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tintree::codec {

/// One BC4 (RGTC) block of signed values: 4 x 4 texels in 8 bytes, as graphics cards read them (Khronos Data Format
/// Specification 1.3, section 18.4): two ends and, for every texel, one of eight values from the one to the other. Two
/// of them side by side are a BC5 block.
inline constexpr std::size_t kBc4BlockBytes = 8;

/// 16 values from -1 to 1, row by row.
using ValueBlock = std::array<float, 16>;
using Bc4Block = std::array<std::byte, kBc4BlockBytes>;

/// Deterministic.
Bc4Block encode_bc4(const ValueBlock& values);
ValueBlock decode_bc4(const Bc4Block& block);

}  // namespace tintree::codec
