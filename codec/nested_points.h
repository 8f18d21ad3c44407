#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/sparse_grid.h"
#include "codec/split_hierarchy.h"

namespace tintree::codec {

/// A point of a hierarchy of right triangles: triangles whose longest side has it as its middle are split there.
struct NestedPoint {
  std::int32_t x = 0;  ///< Address steps, as GridVertex.
  std::int32_t y = 0;
  std::int32_t z = 0;       ///< Of a gap: nothing.
  std::uint8_t level = 0;   ///< The nested level that first has it, 0 the coarsest.
  bool gap = false;         ///< There is no surface here: triangles at it are left out.
  std::int32_t end_a = -1;  ///< Ends of the side that it splits; -1 for the five points that are always there.
  std::int32_t end_b = -1;
};

/// Nested meshes of right triangles over one tile (Schneider and Westermann 2006, section 4): four round the tile's
/// centre, split at the middle of the longest side wherever there is a point. The points up to a level make that
/// level's mesh, and each triangle of a level lies in one of the level before. Points are numbered as they were added,
/// from the five that are always there: the corners north-west, north-east, south-west, south-east, and the centre.
class NestedPoints {
 public:
  /// The tile's side is `2^side_bits` address steps (1 to kMostSideBits).
  explicit NestedPoints(int side_bits) : side_(1 << side_bits), places_(side_) {}

  static constexpr int kMostSideBits = 18;
  static constexpr std::int32_t kBasePoints = 5;
  static constexpr std::int32_t kNone = kNoPoint;

  std::int32_t side() const { return side_; }
  /// Where the point of this number, one of the five, lies.
  std::array<std::int32_t, 2> base_place(std::int32_t number) const {
    if (number == kBasePoints - 1) return {side_ / 2, side_ / 2};
    return {(number & 1) * side_, (number >> 1) * side_};
  }
  const std::vector<NestedPoint>& points() const { return points_; }
  const NestedPoint& point(std::int32_t i) const { return points_[static_cast<std::size_t>(i)]; }
  std::int32_t find(std::int32_t x, std::int32_t y) const { return places_.get(x, y); }
  std::int32_t add(const NestedPoint& point) {
    const auto number = static_cast<std::int32_t>(points_.size());
    places_.set(point.x, point.y, number);
    points_.push_back(point);
    return number;
  }

  /// Visits all triangles along a space-filling curve. `split(a, b, c, x, y)` gives the point at (x, y), the middle of
  /// a-b, of the triangle with the right angle at c, or kNone; without it `leaf(a, b, c)` is called. Corners are
  /// counter-clockwise from above. The five points must be there; `split` may add others.
  template <typename Split, typename Leaf>
  void walk(const Split& split, const Leaf& leaf) const {
    const auto middle = [&](std::int32_t a, std::int32_t b, std::int32_t c) -> std::optional<std::int32_t> {
      const std::int32_t x = point(a).x + point(b).x;
      const std::int32_t y = point(a).y + point(b).y;
      const std::int32_t found = ((x | y) & 1) != 0 ? kNone : split(a, b, c, x / 2, y / 2);
      return found == kNone ? std::nullopt : std::optional(found);
    };
    for (const auto& [a, b] : kSquareSides) bisect(a, b, kBasePoints - 1, middle, leaf);
  }

  /// Calls `emit(a, b, c)` for each triangle of the mesh of a level that has surface.
  template <typename Emit>
  void for_each_triangle(int level, const Emit& emit) const {
    walk(
        [&](std::int32_t, std::int32_t, std::int32_t, std::int32_t x, std::int32_t y) {
          const std::int32_t p = find(x, y);
          return p != kNone && point(p).level <= level ? p : kNone;
        },
        [&](std::int32_t a, std::int32_t b, std::int32_t c) {
          if (!point(a).gap && !point(b).gap && !point(c).gap) emit(a, b, c);
        });
  }

 private:
  std::int32_t side_;
  std::vector<NestedPoint> points_;
  PointNumbers places_;
};

}  // namespace tintree::codec
