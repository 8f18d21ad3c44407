#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "codec/quick_bit_model.h"
#include "codec/range_coder.h"

namespace tintree::codec {

/// A vertex of a mesh of right triangles, as far as others go by it.
struct SplitHeight {
  bool there = false;  ///< Not where it is missing, not known yet or beyond the tile.
  std::int64_t z = 0;
  int digits = 0;  ///< Of how far it was off what was expected.
};

/// Codes heights of points at which right triangles are split, coarse ones first, by what lies around them: expected is
/// the middle of the side that is split, and to which side of it, and how far, the apexes and the errors before tell.
class SplitHeights {
 public:
  /// `around`: the ends of the side, then the right angles of the two triangles. `z`: what is to be written. Heights
  /// are below 2^23 in size; damaged bytes give anything below 2^62.
  template <typename Coder>
  SplitHeight code(Coder& coder, const std::array<SplitHeight, 4>& around, std::int64_t z) {
    const auto& [a, b, c, d] = around;
    const std::int64_t expected = middle(a, b);
    const std::int64_t bend = c.there && d.there ? middle(c, d) - expected : 0;
    const int size = digits(bend);
    const int rough = std::max({a.digits, b.digits, c.digits, d.digits});
    const std::size_t column = bend == 0 ? 0 : size + 1 < rough ? 1 : size <= rough ? 2 : 3;
    const std::int64_t sign = bend < 0 ? -1 : 1;
    const std::int64_t off = sign * models_[std::min(static_cast<std::size_t>(rough), kRough - 1)][column].code(
                                        coder, sign * (z - expected));
    last_ = expected + off;
    return {true, last_, digits(off)};
  }

 private:
  static int digits(std::int64_t v) {
    return static_cast<int>(std::bit_width(static_cast<std::uint64_t>(std::abs(v))));
  }
  std::int64_t middle(const SplitHeight& a, const SplitHeight& b) const {
    if (a.there && b.there) return (a.z + b.z) >> 1;
    return a.there ? a.z : b.there ? b.z : last_;
  }

  static constexpr std::size_t kRough = 16;
  std::array<std::array<NumberModelOf<QuickBitModel>, 4>, kRough> models_;
  std::int64_t last_ = 0;
};

}  // namespace tintree::codec
