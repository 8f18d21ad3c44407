#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/range_coder.h"
#include "codec/right_triangle_code.h"
#include "codec/split_hierarchy.h"
#include "codec/spot_map.h"

namespace tintree::codec {

/// What encode_right_triangles() and decode_right_triangles() do alike.

/// Cells along the side of one of the squares that all starts from.
inline std::int64_t right_triangle_square(std::int64_t cells) {
  constexpr std::int64_t kSquares = 16;
  return std::max<std::int64_t>(1, cells / kSquares);
}

/// One number a point.
inline std::uint64_t split_key(const SplitPoint& p) {
  return static_cast<std::uint64_t>(p.y) << 32 | static_cast<std::uint64_t>(p.x);
}

/// A point at which triangles are split, or a corner of the squares.
struct RightTrianglePoint {
  SplitPoint spot;
  std::int64_t unit = 0;  ///< Half the side of the square whose middle, or whose side's middle, it is.
  bool exists = true;     ///< Whether it is a vertex of the mesh.
  std::int64_t z = 0;     ///< Height in steps from height 0.
  std::int64_t guess = 0;
  std::int64_t bend = 0;  ///< How far off the middle of its longest side, in quarter steps; of corners 0.
};

/// What differs between the two ways: each takes the truth, or ignores it, and returns it.
class RightTriangleCoder {
 public:
  virtual ~RightTriangleCoder() = default;
  virtual bool bit(BitModel& model, bool truth) = 0;
  virtual std::int64_t number(NumberModel& model, std::int64_t truth) = 0;
  /// Of the mesh that is put: is there a split, a vertex (with its height), a triangle?
  virtual bool splits(const SplitPoint& spot) const = 0;
  virtual bool height(const SplitPoint& spot, std::int64_t& z) const = 0;
  virtual bool has(const std::array<SplitPoint, 3>& triangle) const = 0;
  virtual bool broken() const = 0;
};

/// The walk over the triangles, the same for both ways.
class RightTriangleWalk {
 public:
  RightTriangleWalk(std::int64_t cells, const HeightGuess& guess, RightTriangleCoder& coder, bool holes)
      : cells_(cells), square_(right_triangle_square(cells)), guess_(&guess), coder_(&coder), holes_(holes) {}

  /// All triangles, as indices of points(); false when the coder broke.
  bool run(std::vector<std::array<std::int32_t, 3>>& triangles);
  const std::vector<RightTrianglePoint>& points() const { return points_; }

 private:
  using Index = std::int32_t;
  using Spot = SplitPoint;
  static constexpr Index kNone = -1;

  /// What is known of a point before it is coded.
  struct Outlook {
    std::int64_t guess = 0;
    std::int64_t flat = 0;       ///< The height between the ends of the longest side, in quarter steps.
    std::int64_t expected = 0;   ///< What the guess adds to that.
    std::int64_t roughness = 0;  ///< How much the points bent that this one depends on.
  };

  static constexpr std::size_t kExpected = 5;
  static constexpr std::size_t kRoughness = 4;

  bool inside(const Spot& s) const { return s.x >= 0 && s.y >= 0 && s.x <= cells_ && s.y <= cells_; }
  Index find(const Spot& s) const {
    const Index* at = by_spot_.find(s);
    return at == nullptr ? kNone : *at;
  }
  Index add(const Spot& spot, std::int64_t unit, const Outlook& outlook);
  void add_corners();
  Outlook look(const Spot& spot, Index a, Index b, std::int64_t roughness) const;
  Index try_split(const Spot& spot, std::int64_t unit, const Spot& a, const Spot& b, std::int64_t roughness, bool side);
  void split_sides(const std::vector<Index>& middles, std::vector<Index>& out);
  void split_middles(const std::vector<Index>& sides, std::vector<Index>& out);
  void descend(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out);
  void emit_half_cell(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out);
  void emit(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out);

  std::int64_t cells_;
  std::int64_t square_;
  const HeightGuess* guess_;
  RightTriangleCoder* coder_;
  bool holes_;
  std::vector<RightTrianglePoint> points_;
  SpotMap<Index> by_spot_;
  bool last_there_ = true;

  std::array<std::array<std::array<BitModel, kRoughness>, kExpected>, 2> split_models_;
  std::array<std::array<NumberModel, 3>, 3> height_models_;
  NumberModel corner_model_;
  std::array<BitModel, 3> exists_models_;
  std::array<BitModel, 2> triangle_models_;
  std::array<BitModel, 2> flip_models_;
};

}  // namespace tintree::codec
