#pragma once

#include <array>
#include <cstdint>

#include "codec/split_hierarchy.h"

namespace tintree::codec {

/// The path that visits every triangle of a restricted quadtree mesh once, across edges only (Dick et al. 2009,
/// section 4.1). A triangle is told by the edges that the path enters and leaves it by: entering edge from `v1` on the
/// left of the path to `v2` on its right, third vertex `v3`; leaving across v1-v3 is winding L, across v3-v2 R.
enum class StripType : std::uint8_t {
  kA,  ///< Enters across a short side and leaves across the other.
  kB,  ///< Enters across a short side and leaves across the longest one.
  kC,  ///< Enters across the longest side.
};

/// The windings follow from the types (the paper's Follow sets): one bit that every type but A turns over.
class StripWinding {
 public:
  /// With the winding of the triangle that comes next, and its type.
  static StripWinding before(StripType type, bool left) { return StripWinding(left == (type == StripType::kB)); }
  StripWinding() = default;

  /// Whether the next triangle, of this type, winds to the left.
  bool next(StripType type) {
    const bool left = right_ == (type == StripType::kB);
    right_ = left == (type == StripType::kC);
    return left;
  }

 private:
  explicit StripWinding(bool right) : right_(right) {}
  bool right_ = false;
};

/// The vector from v1 to v2 is one of 8 directions, counter-clockwise in steps of 45 degrees from east, times 2^size
/// in the longer coordinate. So is that of the next entering edge.
struct StripEdge {
  int direction = 0;
  int size = 0;

  /// After a triangle; size is -1 where the grid has no such point.
  constexpr StripEdge next(StripType type, bool left) const {
    const bool diagonal = (direction & 1) != 0;
    const int turn = type == StripType::kA ? 2 : 1;
    const int grow = type == StripType::kB ? (diagonal ? 1 : 0) : type == StripType::kC ? (diagonal ? 0 : -1) : 0;
    return {(direction + (left ? turn : 8 - turn)) & 7, size + grow};
  }
};

/// Directions in x (eastward) and y (southward).
inline constexpr std::array<int, 8> kStripX{1, 1, 0, -1, -1, -1, 0, 1};
inline constexpr std::array<int, 8> kStripY{0, -1, -1, -1, 0, 1, 1, 1};

/// A triangle of the path.
struct StripStep {
  StripType type;
  bool left;
  SplitPoint v1, v2, v3;
};

namespace detail {

template <typename IsSplit, typename Visit>
void walk_strip(const StripStep& s, const IsSplit& is_split, const Visit& visit) {
  // The longest side is opposite to the right angle.
  const SplitPoint& p = s.type == StripType::kC || (s.type == StripType::kB) == s.left ? s.v1 : s.v2;
  const SplitPoint& q = s.type == StripType::kC ? s.v2 : s.v3;
  const SplitPoint m{(p.x + q.x) / 2, (p.y + q.y) / 2};
  if (((p.x + q.x) & 1) != 0 || ((p.y + q.y) & 1) != 0 || !is_split(m)) return visit(s);
  // The replacement system (figure 4): A -> C B, B -> C A with the winding turned in C, C -> A B with it turned in B.
  const bool l = s.left;
  switch (s.type) {
    case StripType::kA:
      walk_strip({StripType::kC, l, s.v1, s.v2, m}, is_split, visit);
      return walk_strip(l ? StripStep{StripType::kB, l, s.v1, m, s.v3} : StripStep{StripType::kB, l, m, s.v2, s.v3},
                        is_split, visit);
    case StripType::kB:
      walk_strip({StripType::kC, !l, s.v1, s.v2, m}, is_split, visit);
      return walk_strip(l ? StripStep{StripType::kA, l, m, s.v2, s.v3} : StripStep{StripType::kA, l, s.v1, m, s.v3},
                        is_split, visit);
    case StripType::kC:
      walk_strip(l ? StripStep{StripType::kA, l, m, s.v2, s.v3} : StripStep{StripType::kA, l, s.v1, m, s.v3}, is_split,
                 visit);
      return walk_strip(l ? StripStep{StripType::kB, !l, m, s.v3, s.v1} : StripStep{StripType::kB, !l, s.v3, m, s.v2},
                        is_split, visit);
  }
}

}  // namespace detail

/// Follows the path through the mesh over a square of 2^n steps, `span`, counter-clockwise round its centre from its
/// north-east corner (figure 3). `is_split(point)` tells whether the triangles that meet there exist.
template <typename IsSplit, typename Visit>
void walk_strip(std::int64_t span, const IsSplit& is_split, const Visit& visit) {
  const SplitPoint centre{span / 2, span / 2};
  const std::array<SplitPoint, 4> corners{{{span, 0}, {0, 0}, {0, span}, {span, span}}};
  for (std::size_t k = 0; k < 4; ++k) {
    detail::walk_strip({StripType::kA, true, centre, corners[k], corners[(k + 1) % 4]}, is_split, visit);
  }
}

}  // namespace tintree::codec
