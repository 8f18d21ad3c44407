#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/error.h"
#include "codec/nested_points.h"

namespace tintree::codec {

/// What a payload of method `nested` holds (docs/format.md).
struct NestedPayload {
  int xy_shift = 0;
  std::int64_t z_offset = 0;
  int side_bits = 0;
  struct Block {
    std::size_t points = 0;  ///< That it adds.
    std::span<const std::byte> bytes;
  };
  std::vector<Block> blocks;  ///< Coarsest first; of those that were not given, `bytes` is empty.
  std::size_t header_bytes = 0;
  std::vector<std::size_t> block_bytes;
};

/// Takes a payload apart; of the blocks, the first `levels` must be whole.
Expected<NestedPayload> parse_nested(std::span<const std::byte> bytes, int levels);
/// Reads the points of the first `levels` blocks.
Expected<NestedPoints> read_points(const NestedPayload& payload, int levels);
/// The way back: all levels of `points`, which come in any order. `written`, empty, gets them as a reader does.
Expected<std::vector<std::byte>> write_nested(int xy_shift, std::int64_t z_offset, int side_bits, int levels,
                                              const NestedPoints& points, NestedPoints& written);

}  // namespace tintree::codec
