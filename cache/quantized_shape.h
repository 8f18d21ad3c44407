#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "codec/grid_frame.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::cache {

/// How a tile of method `scalar` puts a vertex into a word of 32 bits: from bit 0 on x, then y, then the index of its
/// height, and in bit 31 whether it is a skirt's foot. Inside the tile the index is one of the tile's quantiser; on its
/// sides, which all tiles at them share, it counts height steps from `side_low` on, so that it is exact. Lengths in
/// address steps. The quantiser is the payload's (codec/height_quantizer.h).
struct QuantizedFormat {
  static constexpr std::uint32_t kFoot = std::uint32_t{1} << 31;

  int x_bits = 0;
  int y_bits = 0;
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::int32_t side_low = 0;
  std::int32_t low = 0;  ///< Of a uniform quantiser, in height steps as its step.
  std::int32_t step = 1;
  /// Where skirts hang: west, north, east, south; -1 for a side that the ground does not go on behind.
  std::array<std::int32_t, 4> borders{};

  std::int32_t x(std::uint32_t word) const { return static_cast<std::int32_t>(word & ((1U << x_bits) - 1)); }
  std::int32_t y(std::uint32_t word) const { return static_cast<std::int32_t>(word >> x_bits & ((1U << y_bits) - 1)); }
  std::int32_t index(std::uint32_t word) const {
    return static_cast<std::int32_t>((word & ~kFoot) >> (x_bits + y_bits));
  }
  bool on_side(std::int32_t at_x, std::int32_t at_y) const {
    return at_x == 0 || at_y == 0 || at_x == width || at_y == height;
  }
};

/// The vertices of a tile of method `scalar` ready for a graphics card that dequantises them (Fowler et al., sections
/// 3.2 and 4). Immutable once made.
struct QuantizedShape {
  /// More places along a side than a card has to have texels for.
  static constexpr std::int32_t kMostSteps = 1 << 10;
  /// More entries than a table on a card may have (OpenGL 3.3).
  static constexpr std::size_t kMostLevels = std::size_t{1} << 16;

  QuantizedFormat format;
  std::vector<std::uint32_t> words;  ///< The surface's vertices, as its mesh has them, then the skirts' feet.
  std::vector<std::int32_t> table;   ///< Heights of the indices, rising (Lloyd-Max); empty for a uniform quantiser.

  /// A tile that lies so many samples or height steps from where they are counted from, or is so large, is a mesh.
  static constexpr std::int32_t kFarthest = 1 << 29;

  codec::GridVertex vertex(std::uint32_t word) const;
  std::size_t bytes() const { return sizeof *this + 4 * (words.size() + table.size()); }
};

struct DrawableTile;

/// Of a decoded tile: one with indices, but with a QuantizedShape in place of vertices. `joined_sides` as
/// make_drawable() takes them. Null for a tile whose vertices do not fit into words, and for one beyond the limits
/// above. Cost: a few nanoseconds a vertex, and the occluder's.
std::unique_ptr<DrawableTile> make_drawable_quantized(const codec::TreeLayout& layout, const codec::TileId& id,
                                                      const codec::TileMesh& mesh, std::uint16_t joined_sides);

}  // namespace tintree::cache
