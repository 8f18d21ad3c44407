#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "codec/height_quantizer.h"

namespace tintree::codec {

/// Writes heights (0 to kMaxHeightAddress) as a quantiser and their indices, as docs/format.md tells: uniform or a
/// table, whichever is shorter.
void put_quantized(std::vector<std::byte>& out, std::span<const std::int32_t> heights);

/// Reads `heights.size()` (1 or more) of them and returns their quantiser; nothing when the bytes are not what
/// put_quantized() writes, or more follow.
std::optional<HeightQuantizer> take_quantized(std::span<const std::byte> bytes, std::span<std::int32_t> heights);

}  // namespace tintree::codec
