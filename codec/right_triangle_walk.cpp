#include "codec/right_triangle_walk.h"

#include <bit>
#include <cstdlib>
#include <utility>

namespace tintree::codec {
namespace {

std::size_t size_class(std::int64_t quarters, std::size_t classes) {
  const auto size = static_cast<std::uint64_t>(std::abs(quarters)) / 4;
  return std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(size)), classes - 1);
}

}  // namespace

bool RightTriangleWalk::run(std::vector<std::array<std::int32_t, 3>>& triangles) {
  add_corners();
  std::vector<Index> sides;
  std::vector<Index> middles;
  const std::int64_t half = square_ / 2;
  for (std::int64_t y = 0; half > 0 && y < cells_; y += square_) {
    for (std::int64_t x = 0; x < cells_; x += square_) {
      const bool even = ((x / square_ + y / square_) & 1) == 0;
      const Spot a{even ? x : x + square_, y};
      const Spot b{even ? x + square_ : x, y + square_};
      const Index middle = try_split({x + half, y + half}, half, a, b, 0, false);
      if (middle != kNone) middles.push_back(middle);
    }
  }
  while (!middles.empty() && !coder_->broken()) {
    sides.clear();
    split_sides(middles, sides);
    middles.clear();
    split_middles(sides, middles);
  }
  for (std::int64_t y = 0; y < cells_; y += square_) {
    for (std::int64_t x = 0; x < cells_ && !coder_->broken(); x += square_) {
      const Spot nw{x, y};
      const Spot ne{x + square_, y};
      const Spot sw{x, y + square_};
      const Spot se{x + square_, y + square_};
      const bool even = ((x / square_ + y / square_) & 1) == 0;
      descend(even ? nw : sw, even ? se : ne, even ? ne : nw, triangles);
      descend(even ? se : ne, even ? nw : sw, even ? sw : se, triangles);
    }
  }
  return !coder_->broken();
}

/// Codes whether it is a vertex, and its height.
std::int32_t RightTriangleWalk::add(const Spot& spot, std::int64_t unit, const Outlook& outlook) {
  RightTrianglePoint point{spot, unit, true, 0, outlook.guess, 0};
  std::int64_t z = 0;
  const bool there = coder_->height(spot, z);
  if (holes_) {
    const Index west = unit == 0 ? find({spot.x - square_, spot.y}) : kNone;
    const std::size_t context = unit > 0 ? 2 : west == kNone || points_[static_cast<std::size_t>(west)].exists ? 0 : 1;
    point.exists = coder_->bit(exists_models_[context], there);
  }
  if (point.exists) {
    const std::int64_t likely = (outlook.flat + outlook.expected + 2) >> 2;
    NumberModel& model =
        unit == 0 ? corner_model_ : height_models_[size_class(outlook.expected, 3)][size_class(outlook.roughness, 3)];
    // Unsigned: what damaged bytes make overflow only wraps round, and is refused at the end.
    point.z = static_cast<std::int64_t>(static_cast<std::uint64_t>(likely) +
                                        static_cast<std::uint64_t>(coder_->number(model, z - likely)));
    point.z = std::clamp(point.z, -kMaxHeightOffset, kMaxHeightOffset);
    if (unit > 0) point.bend = 4 * point.z - outlook.flat;
  }
  const auto index = static_cast<Index>(points_.size());
  points_.push_back(point);
  by_spot_.insert(spot, index);
  return index;
}

/// Each from its western or northern neighbour and what the guess rises from there.
void RightTriangleWalk::add_corners() {
  for (std::int64_t y = 0; y <= cells_; y += square_) {
    for (std::int64_t x = 0; x <= cells_; x += square_) {
      if (coder_->broken()) return;
      Index from = x > 0 ? find({x - square_, y}) : find({x, y - square_});
      if (from != kNone && !points_[static_cast<std::size_t>(from)].exists) from = kNone;
      Outlook outlook{(*guess_)(x, y), 0, 0, 0};
      outlook.flat = outlook.guess;
      if (from != kNone) {
        const RightTrianglePoint& point = points_[static_cast<std::size_t>(from)];
        outlook.flat += 4 * point.z - point.guess;
      }
      add({x, y}, 0, outlook);
    }
  }
}

RightTriangleWalk::Outlook RightTriangleWalk::look(const Spot& spot, Index a, Index b, std::int64_t roughness) const {
  Outlook out;
  out.guess = (*guess_)(spot.x, spot.y);
  out.roughness = roughness;
  const RightTrianglePoint& p = points_[static_cast<std::size_t>(a)];
  const RightTrianglePoint& q = points_[static_cast<std::size_t>(b)];
  if (p.exists && q.exists) {
    out.flat = 2 * (p.z + q.z);
    out.expected = out.guess - ((p.guess + q.guess) >> 1);
  } else if (p.exists || q.exists) {
    const RightTrianglePoint& r = p.exists ? p : q;
    out.flat = 4 * r.z;
    out.expected = out.guess - r.guess;
  } else {
    out.flat = out.guess;
  }
  return out;
}

std::int32_t RightTriangleWalk::try_split(const Spot& spot, std::int64_t unit, const Spot& a, const Spot& b,
                                          std::int64_t roughness, bool side) {
  if (coder_->broken()) return kNone;
  const Index p = find(a);
  const Index q = find(b);
  if (p == kNone || q == kNone) return kNone;
  const Outlook outlook = look(spot, p, q, roughness);
  BitModel& model =
      split_models_[side ? 1 : 0][size_class(outlook.expected, kExpected)][size_class(roughness, kRoughness)];
  return coder_->bit(model, coder_->splits(spot)) ? add(spot, unit, outlook) : kNone;
}

/// The middles of the sides of squares whose own middles are there on both sides of it.
void RightTriangleWalk::split_sides(const std::vector<Index>& middles, std::vector<Index>& out) {
  for (const Index index : middles) {
    const RightTrianglePoint point = points_[static_cast<std::size_t>(index)];
    const auto [x, y] = point.spot;
    const std::int64_t u = point.unit;
    for (const auto& [dx, dy] :
         {std::pair{-u, std::int64_t{0}}, {u, std::int64_t{0}}, {std::int64_t{0}, -u}, {std::int64_t{0}, u}}) {
      const Spot spot{x + dx, y + dy};
      const Spot across{x + 2 * dx, y + 2 * dy};
      std::int64_t roughness = std::abs(point.bend);
      if (inside(across)) {
        const Index other = find(across);
        if (other == kNone || other > index) continue;  // its turn comes with the later of the two
        roughness = std::max(roughness, std::abs(points_[static_cast<std::size_t>(other)].bend));
      }
      const Spot a{spot.x + dy, spot.y + dx};
      const Spot b{spot.x - dy, spot.y - dx};
      const Index made = try_split(spot, u, a, b, roughness, true);
      if (made != kNone) out.push_back(made);
    }
  }
}

/// The middles of squares with two opposite corners that are middles of larger squares' sides.
void RightTriangleWalk::split_middles(const std::vector<Index>& sides, std::vector<Index>& out) {
  for (const Index index : sides) {
    const RightTrianglePoint point = points_[static_cast<std::size_t>(index)];
    const std::int64_t side = point.unit;
    const std::int64_t v = side / 2;
    if (v == 0) continue;
    for (const auto& [dx, dy] : {std::pair{-v, -v}, {v, -v}, {-v, v}, {v, v}}) {
      const Spot spot{point.spot.x + dx, point.spot.y + dy};
      const Spot opposite{spot.x + dx, spot.y + dy};
      if (!inside(opposite)) continue;
      const Index other = find(opposite);
      if (other == kNone || other > index) continue;
      const std::int64_t roughness =
          std::max(std::abs(point.bend), std::abs(points_[static_cast<std::size_t>(other)].bend));
      const Index made = try_split(spot, v, {spot.x + dx, spot.y - dy}, {spot.x - dx, spot.y + dy}, roughness, false);
      if (made != kNone) out.push_back(made);
    }
  }
}

/// Triangle with longest side a-b and apex c, counter-clockwise from above.
void RightTriangleWalk::descend(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out) {
  if (std::abs(a.x - b.x) == 1 && std::abs(a.y - b.y) == 1) return emit_half_cell(a, b, c, out);
  const Spot middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
  if (find(middle) == kNone) return emit(a, b, c, out);
  descend(c, a, middle, out);
  descend(b, c, middle, out);
}

/// Half a cell of the DEM. Where the other half is a triangle too, the two get the surface's own diagonal, but for two
/// corners of the tile where a bit may say otherwise.
void RightTriangleWalk::emit_half_cell(const Spot& a, const Spot& b, const Spot& c,
                                       std::vector<std::array<Index, 3>>& out) {
  const Spot d{a.x + b.x - c.x, a.y + b.y - c.y};
  const bool along = (a.x - b.x) == (a.y - b.y);
  if (along || find(c) == kNone || find(d) == kNone) return emit(a, b, c, out);
  const Spot cell{std::min(a.x, b.x), std::min(a.y, b.y)};
  const std::int64_t last = cells_ - 1;
  if ((cell.x == 0 && cell.y == last) || (cell.x == last && cell.y == 0)) {
    if (coder_->bit(flip_models_[cell.x == 0 ? 0 : 1], coder_->has({a, b, c}))) return emit(a, b, c, out);
  }
  emit(c, a, d, out);
}

void RightTriangleWalk::emit(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out) {
  const std::array<Index, 3> corners{find(a), find(b), find(c)};
  for (const Index corner : corners) {
    if (corner == kNone || !points_[static_cast<std::size_t>(corner)].exists) return;
  }
  if (holes_) {
    last_there_ = coder_->bit(triangle_models_[last_there_ ? 1 : 0], coder_->has({a, b, c}));
    if (!last_there_) return;
  }
  out.push_back(corners);
}

}  // namespace tintree::codec
