#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace tintree::codec {

/// Deepest level a tree can have: a key holds 6 bits of level and 2 x 29 bits of position.
inline constexpr int kMaxLevel = 29;

/// Names one tile of the quadtree; TreeLayout knows its parent and its children. Level 0 is the root, which covers the
/// whole DEM.
/// `x` counts tiles eastward from the DEM's west side, `y` southward from its north side.
struct TileId {
  int level = 0;
  std::uint32_t x = 0;
  std::uint32_t y = 0;

  friend bool operator==(const TileId&, const TileId&) = default;

  /// Position along the Z-order curve of this level (x in the even bits, y in the odd bits).
  std::uint64_t morton() const;

  /// level * 2^58 + morton: ascending keys go level by level, siblings side by side.
  std::int64_t key() const;
  static TileId from_key(std::int64_t key);

  /// "level/x/y", the way every message names a tile.
  std::string text() const;
};

}  // namespace tintree::codec
