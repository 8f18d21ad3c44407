#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/strip_payload.h"

namespace tintree::codec {

/// Decoding to a list of triangles, three words of 32 bits each, that is drawn straight from the index buffer (Dick et
/// al. 2009, sections 5 and 6): a word is a vertex, x in the lowest xy_bits, y in as many, then the height. All
/// decoders, here and on the graphics card, give the same words in the same order.
struct StripWords {
  int xy_bits = 0;      ///< One more than the tile's levels: coordinates reach 2^levels.
  int height_bits = 0;  ///< As in the payload.

  /// The uppermost bit of a vertex at the foot of a skirt.
  static constexpr std::uint32_t kFoot = std::uint32_t{1} << 31;

  explicit StripWords(const StripHead& p) : xy_bits(p.levels + 1), height_bits(p.height_bits) {}
  /// Whether vertices fit into words. Where they do not (tall and fine tiles) decode() is what there is.
  bool fit() const { return 2 * xy_bits + height_bits < 32; }
  std::uint32_t pack(std::int32_t x, std::int32_t y, std::uint32_t height) const {
    return static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << xy_bits | height << 2 * xy_bits;
  }
  std::uint32_t x(std::uint32_t word) const { return word & ((1U << xy_bits) - 1); }
  std::uint32_t y(std::uint32_t word) const { return x(word >> xy_bits); }
  std::uint32_t height(std::uint32_t word) const { return (word & ~kFoot) >> 2 * xy_bits; }
};

/// Whether a graphics card unpacks such a strip: headers of 32 bits, vertices that fit into words. Others are drawn as
/// meshes.
inline bool unpacks_on_card(const StripHead& head) { return head.levels <= kShortLevels && StripWords(head).fit(); }

/// Follows the strip from its first triangle. `words` has room for 3 a triangle and fit() holds; a triangle with a
/// missing corner becomes three zeros. The payload is one that StripMesh::decode() has accepted; another gives a wrong
/// list, but touches nothing else. Cost: see docs/methods.md.
void follow_strip(const StripPayload& payload, std::span<std::uint32_t> words);

/// The same, every sub-strip from its own header, eight of them at a time.
void expand_sub_strips(const StripPayload& payload, std::span<std::uint32_t> words);

/// Where skirts hang: x of the western border, y of the northern, x of the eastern, y of the southern; -1 for a border
/// without.
using StripBorders = std::array<std::int32_t, 4>;
/// All sides of a whole tile.
inline StripBorders whole_borders(int levels) { return {0, 0, 1 << levels, 1 << levels}; }

/// The skirts of a list: two triangles down from every side of a triangle that lies on one of the borders, in the order
/// of the triangles (section 5.1). How deep they reach is for whoever draws them to say: their feet are marked.
std::vector<std::uint32_t> strip_skirts(const StripPayload& payload, std::span<const std::uint32_t> words,
                                        const StripBorders& borders);

}  // namespace tintree::codec
