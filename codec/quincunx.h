#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace tintree::codec {

/// One refinement of a quincunx lattice over a square: the places in the middles of four known ones, which lie
/// diagonally or straight at `half` the spacing of the lattice that is refined.
struct QuincunxPass {
  struct Step {
    int x, y;
  };
  /// The known places around one: the four nearest, two opposite pairs, then the next eight.
  using Around = std::array<Step, 12>;

  int half = 1;
  bool diagonal = true;

  const Around& around() const { return diagonal ? kDiagonal : kStraight; }
  /// How far the twelve reach.
  int reach() const { return half * (diagonal ? 3 : 2); }

  /// f(x, y) for every place, row by row.
  template <typename F>
  void each(int side, const F& f) const {
    for (int y = diagonal ? half : 0; y < side; y += diagonal ? 2 * half : half) {
      for (int x = diagonal || (y / half & 1) == 0 ? half : 0; x < side; x += 2 * half) f(x, y);
    }
  }

 private:
  static constexpr Around kDiagonal{
      {{-1, -1}, {1, 1}, {1, -1}, {-1, 1}, {-3, -1}, {-1, -3}, {1, -3}, {3, -1}, {-3, 1}, {-1, 3}, {1, 3}, {3, 1}}};
  static constexpr Around kStraight{
      {{0, -1}, {0, 1}, {1, 0}, {-1, 0}, {-1, -2}, {1, -2}, {2, -1}, {2, 1}, {1, 2}, {-1, 2}, {-2, 1}, {-2, -1}}};
};

/// How the places of a pass are foretold.
struct QuincunxFilter {
  static constexpr int kBlends = 7;
  static constexpr int kEdges = 3;
  /// In quarters: 0, from the heights around; 4, from what these are beyond the prediction; others between and beyond.
  int blend = 4;
  /// 0, the mean of the nearest four; 1, the Neville filter of order 4 (10/32 of these, -1/32 of the next eight);
  /// 2, with twice its share of the next.
  int edge = 1;
};

/// What is known at a place all of whose twelve are inside the square.
struct QuincunxPlace {
  std::size_t index = 0;      ///< Of its sample.
  std::int64_t foretold = 0;  ///< The prediction there; then its sums over the nearest four and the next eight,
  std::int64_t near_foretold = 0;
  std::int64_t next_foretold = 0;
  std::int64_t near = 0;  ///< and those of the reconstructed heights.
  std::int64_t next = 0;
  std::int64_t twist = 0;  ///< One pair of opposite heights less the other.

  /// In 32nds.
  std::int64_t expected(const QuincunxFilter& f) const {
    const std::int64_t own = 8 * near + f.edge * (2 * near - next);
    const std::int64_t beyond = 32 * foretold - 8 * near_foretold - f.edge * (2 * near_foretold - next_foretold);
    return own + (beyond * f.blend >> 2);
  }
  /// How much the heights around bend, in 16ths.
  std::int64_t bend() const { return std::abs(2 * near - next) + 4 * std::abs(twist); }
};

}  // namespace tintree::codec
