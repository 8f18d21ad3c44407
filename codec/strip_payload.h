#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "codec/error.h"
#include "codec/strip_path.h"

namespace tintree::codec {

/// Triangles that share a header.
inline constexpr std::uint32_t kSubStrip = 16;
/// A tile's side is at most 2^this steps; up to 2^kShortLevels a header takes 32 bits, else 64.
inline constexpr int kMaxStripLevels = 17;
inline constexpr int kShortLevels = 10;
inline constexpr int kMaxStripHeightBits = 23;

/// A header (Dick et al. 2009, section 4.2): what a sub-strip begins with.
struct StripHeader {
  std::int32_t x = 0;  ///< Of v1.
  std::int32_t y = 0;
  StripEdge edge;          ///< From v1 to v2.
  std::uint32_t back = 2;  ///< Entries back to the height of the vertex that is not the one before: 2 to 9.
  bool back_is_v1 = true;  ///< Whose height that is; the other's is 1 back.
  bool left = true;        ///< Winding of the first triangle.

  friend bool operator==(const StripHeader& a, const StripHeader& b) {
    return a.x == b.x && a.y == b.y && a.edge.direction == b.edge.direction && a.edge.size == b.edge.size &&
           a.back == b.back && a.back_is_v1 == b.back_is_v1 && a.left == b.left;
  }
};

/// Where the parts of a header lie, from the lowest bit: x, y, direction 3, size, back 3, back_is_v1 1, left 1.
struct StripHeaderLayout {
  int xy_bits = 10;
  int size_bits = 4;
  std::size_t bytes = 4;

  static StripHeaderLayout of(int levels) {
    return levels <= kShortLevels ? StripHeaderLayout{} : StripHeaderLayout{20, 5, 8};
  }
  std::uint64_t pack(const StripHeader& h) const;
  StripHeader unpack(std::uint64_t bits) const;
};

/// What a payload begins with (docs/format.md, Payload of method `strip`).
struct StripHead {
  int xy_shift = 0;
  std::int64_t z_offset = 0;
  int levels = 0;       ///< The tile is 2^levels steps wide.
  int fine = 0;         ///< Steps are 2^-fine address steps.
  int height_bits = 0;  ///< Of an entry's height.
  int z_shift = 0;      ///< Heights count 2^z_shift height steps.
  bool holes = false;   ///< The greatest height means that the vertex is missing, and its triangles.
  std::uint32_t triangles = 0;

  std::uint32_t sub_strips() const { return (triangles + kSubStrip - 1) / kSubStrip; }
  std::uint32_t missing() const { return holes ? (1U << height_bits) - 1 : UINT32_MAX; }
};

/// A payload of version 1 taken apart, the sizes of its parts checked against each other.
struct StripPayload : StripHead {
  std::span<const std::byte> headers;
  std::span<const std::byte> entries;

  StripHeader header(std::uint32_t sub_strip) const {
    const StripHeaderLayout layout = StripHeaderLayout::of(levels);
    std::uint64_t bits = 0;
    std::memcpy(&bits, headers.data() + sub_strip * layout.bytes, layout.bytes);
    return layout.unpack(bits);
  }
  /// Entry `index`: type in the lowest 2 bits, then the height. Index + 2 is a triangle's, 0 and 1 hold the heights of
  /// the first entering edge.
  std::uint32_t entry(std::size_t index) const {
    const std::size_t bits = static_cast<std::size_t>(height_bits) + 2;
    const std::size_t at = index * bits;
    std::uint64_t word = 0;
    const std::size_t byte = at >> 3;
    if (byte + 8 <= entries.size()) {
      std::memcpy(&word, entries.data() + byte, 8);
    } else {
      std::memcpy(&word, entries.data() + byte, entries.size() - byte);
    }
    return static_cast<std::uint32_t>(word >> (at & 7)) & ((1U << bits) - 1);
  }
};

/// Payload versions.
inline constexpr auto kStripPacked = std::byte{1};
inline constexpr auto kStripCoded = std::byte{3};

void put_strip_head(std::vector<std::byte>& out, std::byte version, const StripHead& head);
/// Reads a head of the version and drops it from `bytes`.
Expected<StripHead> take_strip_head(std::span<const std::byte>& bytes, std::byte version);

/// The head of a payload of either version.
Expected<StripHead> read_strip_head(std::span<const std::byte> bytes);

/// Takes a payload of version 1 apart, whose bytes must outlive the result.
Expected<StripPayload> open_strip(std::span<const std::byte> bytes);

}  // namespace tintree::codec
