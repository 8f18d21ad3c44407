#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace tintree::codec {

/// A point of a square grid of 2^n steps a side, x eastward and y southward from its north-west corner.
///
/// Longest-edge bisection makes every point but the grid's corners the middle of the longest side, the hypotenuse, of
/// two right triangles. With u the largest power of two that divides both coordinates, (x / u, y / u) both odd is the
/// centre of a square of side 2u, cut along the diagonal from north-west to south-east where the square's numbers add
/// up to an even one, else along the other; one odd is the middle of such a square's side. A split at a point needs
/// that its two triangles exist, so that their apexes, the point's parents, are split before (Dick et al. 2009,
/// section 4; Evans et al. 2001).
struct SplitPoint {
  std::int64_t x = 0;
  std::int64_t y = 0;

  friend bool operator==(const SplitPoint&, const SplitPoint&) = default;
};

/// u as above; 0 at the grid's origin.
inline std::int64_t split_unit(const SplitPoint& p) { return (p.x | p.y) & -(p.x | p.y); }

/// Where the two triangles that are split at a point have their right angles; outside the grid for one of them where
/// the point lies on its side. Not for the grid's centre and corners.
inline std::array<SplitPoint, 2> split_parents(const SplitPoint& p) {
  const std::int64_t u = split_unit(p);
  const bool odd_x = (p.x & u) != 0;
  const bool odd_y = (p.y & u) != 0;
  if (!odd_y) return {{{p.x, p.y - u}, {p.x, p.y + u}}};
  if (!odd_x) return {{{p.x - u, p.y}, {p.x + u, p.y}}};
  const std::int64_t side = 2 * u;
  const std::int64_t west = p.x - u;
  const std::int64_t north = p.y - u;
  const bool even = ((west / side + north / side) & 1) == 0;
  return {{{even ? west + side : west, north}, {even ? west : west + side, north + side}}};
}

/// The points whose parent a point is; those on the same grid of half the step where it is the middle of a side of
/// one step's length, which are meaningless then. Some lie outside where the point is on the grid's side.
inline std::array<SplitPoint, 4> split_children(const SplitPoint& p) {
  const std::int64_t u = split_unit(p);
  if ((p.x & p.y & u) != 0) return {{{p.x, p.y - u}, {p.x - u, p.y}, {p.x + u, p.y}, {p.x, p.y + u}}};
  const std::int64_t h = u / 2;
  return {{{p.x - h, p.y - h}, {p.x + h, p.y - h}, {p.x - h, p.y + h}, {p.x + h, p.y + h}}};
}

/// Splits at a point and, before that counts, at all that its triangles need. `set(point)` notes a split and tells
/// whether it is new; it says no beyond the grid, and where its triangles are there from the start.
template <typename Set>
void force_split(const SplitPoint& p, const Set& set) {
  if (!set(p)) return;
  for (const SplitPoint& parent : split_parents(p)) force_split(parent, set);
}

/// Visits a triangle's parts along a space-filling curve: longest side a-b, right angle at c, counter-clockwise from
/// above. `split(a, b, c)` gives the point in the middle of a-b, as corners are given, or none; then `leaf(a, b, c)`
/// is called.
template <typename Corner, typename Split, typename Leaf>
void bisect(const Corner& a, const Corner& b, const Corner& c, const Split& split, const Leaf& leaf) {
  const std::optional<Corner> middle = split(a, b, c);
  if (!middle) return leaf(a, b, c);
  bisect(c, a, *middle, split, leaf);
  bisect(b, c, *middle, split, leaf);
}

/// The four triangles round a square's centre, as the ends of their longest sides: the square's corners, of which bit
/// 0 says east, bit 1 south.
inline constexpr std::array<std::array<std::int32_t, 2>, 4> kSquareSides{{{1, 0}, {0, 2}, {2, 3}, {3, 1}}};

}  // namespace tintree::codec
