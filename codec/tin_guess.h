#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "codec/tin_front.h"

namespace tintree::codec {

/// No x or y of a TinWalk is greater: products of distances and heights fit 64 bits.
inline constexpr std::int32_t kMostTinPlace = 1 << 22;

inline std::int64_t squared_distance(const GridVertex& a, const GridVertex& b) {
  const std::int64_t x = b.x - a.x;
  const std::int64_t y = b.y - a.y;
  return x * x + y * y;
}

/// Where to expect the third vertex of the triangle at a gate, and around there a frame: `along` the gate and `across`
/// it, both in address steps along the axes, one of eight ways.
class PlaceGuess {
 public:
  /// `doubled_area` is what triangles have had of late, 0 if there were none.
  PlaceGuess(TinFront& front, TinFront::Index gate, std::int64_t doubled_area, std::int32_t width,
             std::int32_t height) {
    const TinFront::Index end = front[gate].next;
    const GridVertex& a = front.point(gate);
    const GridVertex& b = front.point(end);
    dx_ = b.x - a.x;
    dy_ = b.y - a.y;
    const std::int64_t squared = std::max<std::int64_t>(1, dx_ * dx_ + dy_ * dy_);
    // The sides of an even triangle, each a third as long as the neighbouring edge and two thirds as the gate.
    const std::int64_t length = std::max<std::int64_t>(1, about_length(a, b));
    const std::int64_t before = std::min(2 * length + about_length(a, front.point(front[gate].previous)), 6 * length);
    const std::int64_t after = std::min(2 * length + about_length(b, front.point(front[end].next)), 6 * length);
    const std::int64_t by_edges = 8 * (before + after) / length;
    const std::int64_t by_area =
        doubled_area == 0 ? kEvenHeight : std::clamp<std::int64_t>(32 * doubled_area / squared, 24, 83);
    const std::int64_t up = (by_edges + by_area) / 2;
    const std::int64_t on = 16 * (before - after) / (3 * length) + kLean[static_cast<std::size_t>(front.turn(gate))] -
                            kLean[static_cast<std::size_t>(front.turn(end))];
    x_ = std::clamp<std::int64_t>((32 * (std::int64_t{a.x} + b.x) + up * dy_ + on * dx_ + 32) >> 6, 0, width);
    y_ = std::clamp<std::int64_t>((32 * (std::int64_t{a.y} + b.y) - up * dx_ + on * dy_ + 32) >> 6, 0, height);
    even_digits_ = std::max(0, (static_cast<int>(std::bit_width(static_cast<std::uint64_t>(squared))) - 1) / 2 - 3);
  }

  struct Offset {
    std::int64_t along = 0;
    std::int64_t across = 0;
  };
  Offset offset_of(const GridVertex& p) const {
    const std::int64_t x = p.x - x_;
    const std::int64_t y = p.y - y_;
    if (std::abs(dx_) >= std::abs(dy_)) return dx_ < 0 ? Offset{-x, y} : Offset{x, -y};
    return dy_ < 0 ? Offset{-y, -x} : Offset{y, x};
  }
  std::array<std::int64_t, 2> place_at(const Offset& o) const {
    if (std::abs(dx_) >= std::abs(dy_)) return dx_ < 0 ? place(-o.along, o.across) : place(o.along, -o.across);
    return dy_ < 0 ? place(-o.across, -o.along) : place(o.across, o.along);
  }
  /// So many low digits of an offset have nothing to tell.
  int even_digits() const { return even_digits_; }

 private:
  std::array<std::int64_t, 2> place(std::int64_t x, std::int64_t y) const { return {x_ + x, y_ + y}; }
  /// Within a twentieth.
  static std::int64_t about_length(const GridVertex& a, const GridVertex& b) {
    const std::int64_t x = std::abs(b.x - a.x);
    const std::int64_t y = std::abs(b.y - a.y);
    return std::max(x, y) + 3 * std::min(x, y) / 8;
  }
  /// In 64ths of the gate.
  static constexpr std::int64_t kEvenHeight = 48;
  /// How far an angle (TinFront::turn) pushes the vertex away, in 64ths of the gate.
  static constexpr std::array<std::int64_t, TinFront::kTurns> kLean{24, 16, 8, 4, -6, 4, 0, 0};

  std::int64_t dx_;
  std::int64_t dy_;
  std::int64_t x_;
  std::int64_t y_;
  int even_digits_;
};

/// The height to expect at a place beyond a gate: the mean of the gate's ends and their neighbours on the front, each
/// weighing as the inverse of its squared distance.
inline std::int64_t guess_height(const TinFront& front, TinFront::Index gate, const GridVertex& at) {
  const TinFront::Index end = front[gate].next;
  const std::array near{gate, end, front[gate].previous, front[end].next};
  std::array<std::int64_t, 4> distance{};
  for (std::size_t i = 0; i < near.size(); ++i)
    distance[i] = std::max<std::int64_t>(1, squared_distance(front.point(near[i]), at));
  const std::int64_t least = *std::ranges::min_element(distance);
  std::int64_t sum = 0;
  std::int64_t weights = 0;
  for (std::size_t i = 0; i < near.size(); ++i) {
    const std::int64_t weight = (least << 16) / distance[i];
    sum += weight * front.point(near[i]).z;
    weights += weight;
  }
  return (sum + weights / 2) / weights;
}

}  // namespace tintree::codec
