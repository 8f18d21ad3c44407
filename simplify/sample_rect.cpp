#include "simplify/sample_rect.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "cache/height_blocks.h"

namespace tintree::simplify {
namespace {

/// Below this weight the hub cannot move a point measurably: it lies on the old outer edge or hard by it.
constexpr float kMinWeight = 1e-6F;

// Eight numbers at a time; compiled once for the machine's baseline and once for AVX2.
#define TINTREE_CLONES __attribute__((target_clones("avx2", "default")))
#define TINTREE_INLINE __attribute__((always_inline)) inline
#define TINTREE_INLINE_LAMBDA __attribute__((always_inline))
using Lanes = float __attribute__((vector_size(32)));
using LaneInts = std::int32_t __attribute__((vector_size(32)));
using LaneWords = std::int64_t __attribute__((vector_size(32)));
constexpr int kLanes = 8;
constexpr Lanes kIota = {0, 1, 2, 3, 4, 5, 6, 7};
/// A lowest height that no height reaches.
constexpr float kUnreachable = std::numeric_limits<float>::infinity();
constexpr LaneInts kIotaInt = {0, 1, 2, 3, 4, 5, 6, 7};

TINTREE_INLINE bool any(const LaneInts& mask) {
  LaneWords words;
  std::memcpy(&words, &mask, sizeof words);
  return (words[0] | words[1] | words[2] | words[3]) != 0;
}

/// The rows in which a triangle may touch a strip of columns.
class StripRows {
 public:
  TINTREE_INLINE StripRows(const SampleRect& samples, const RectTriangle& t) : samples_(samples), t_(t) {
    if (samples.columns <= kLanes) return;
    for (std::size_t k = 0; k < 3; ++k) per_area_[k] = 1.0 / (t.sides[k].per_row == 0 ? 1 : t.sides[k].per_row);
  }

  struct Rows {
    int first;
    int end;
  };
  TINTREE_INLINE Rows at(int column) const {
    if (samples_.columns <= kLanes) return {0, samples_.rows};
    double first = 0;
    double last = samples_.rows - 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const Linear<std::int32_t>& side = t_.sides[k];
      // Its value in row 0 where the strip reaches farthest inside.
      const double most =
          side.start + static_cast<double>(column + (side.per_column > 0 ? kLanes - 1 : 0)) * side.per_column;
      if (side.per_row > 0) first = std::max(first, -most * per_area_[k] - kSlack);
      if (side.per_row < 0) last = std::min(last, -most * per_area_[k] + kSlack);
    }
    return {static_cast<int>(std::min<double>(first, samples_.rows)), last < 0 ? 0 : static_cast<int>(last) + 1};
  }

 private:
  static constexpr double kSlack = 1e-3;

  const SampleRect& samples_;
  const RectTriangle& t_;
  double per_area_[3];
};

/// Calls `visit(here, weight, residual)` for the samples of a rectangle, eight at a time, strip by strip: `here` is set
/// for those inside of the first kSides sides. The residual is against the plane.
template <int kSides, typename Visit>
TINTREE_INLINE void for_each_eight(const SampleRect& samples, const RectTriangle& t, const Visit& visit) {
  float weight_at[kMaxRectSamples];
  float height_at[kMaxRectSamples];
  for (int j = 0; j < samples.rows; ++j) {
    weight_at[j] = static_cast<float>(t.weight.start + j * t.weight.per_row);
    height_at[j] = static_cast<float>(t.height.start + j * t.height.per_row);
  }
  const StripRows strips(samples, t);
  for (int i = 0; i < samples.columns; i += kLanes) {
    const Lanes at = kIota + static_cast<float>(i);
    const LaneInts exists = at < static_cast<float>(samples.columns);
    const Lanes weight_along = at * static_cast<float>(t.weight.per_column);
    const Lanes height_along = at * static_cast<float>(t.height.per_column);
    const StripRows::Rows rows = strips.at(i);
    LaneInts area[kSides];
    for (int k = 0; k < kSides; ++k) {
      const Linear<std::int32_t>& side = t.sides[static_cast<std::size_t>(k)];
      area[k] = (side.start + rows.first * side.per_row) + (kIotaInt + i) * side.per_column;
    }
    const float* row = samples.heights + rows.first * cache::kBlockStride + i;
    for (int j = rows.first; j < rows.end; ++j, row += cache::kBlockStride) {
      LaneInts signs = area[0];
      for (int k = 1; k < kSides; ++k) signs |= area[k];
      for (int k = 0; k < kSides; ++k) area[k] += t.sides[static_cast<std::size_t>(k)].per_row;
      Lanes h;
      std::memcpy(&h, row, sizeof h);
      visit(exists & (signs >= 0), weight_at[j] + weight_along, h - (height_at[j] + height_along));
    }
  }
}

/// Whether any sample narrows the interval.
template <bool kLight>
TINTREE_INLINE bool narrows(const SampleRect& samples, const RectTriangle& t, float bound, float lo, float hi) {
  LaneInts found = {};
  for_each_eight<kLight ? 3 : 2>(
      samples, t, [&](const LaneInts& here, const Lanes& weight, const Lanes& residual) TINTREE_INLINE_LAMBDA {
        const LaneInts beyond = (residual - bound > lo * weight) | (residual + bound < hi * weight);
        found |= here & beyond & (weight > kMinWeight);
        if (kLight) found |= here & (weight <= kMinWeight) & ((residual > bound) | (residual < -bound));
      });
  return any(found);
}

template <bool kLight>
TINTREE_INLINE void narrow(const SampleRect& samples, const RectTriangle& t, float bound, float& lo, float& hi) {
  Lanes best_lo = kIota * 0 + lo;
  Lanes best_hi = kIota * 0 + hi;
  for_each_eight<kLight ? 3 : 2>(
      samples, t, [&](const LaneInts& here, const Lanes& weight, const Lanes& residual) TINTREE_INLINE_LAMBDA {
        const Lanes low = (residual - bound) / weight;
        const Lanes high = (residual + bound) / weight;
        const LaneInts counts = here & (weight > kMinWeight);
        best_lo = counts & (low > best_lo) ? low : best_lo;
        best_hi = counts & (high < best_hi) ? high : best_hi;
        if (kLight) {
          const LaneInts stuck = here & (weight <= kMinWeight) & ((residual > bound) | (residual < -bound));
          best_lo = stuck ? (kIota - kIota) + kUnreachable : best_lo;
        }
      });
  for (int i = 0; i < kLanes; ++i) {
    lo = std::max(lo, best_lo[i]);
    hi = std::min(hi, best_hi[i]);
  }
}

}  // namespace

// Most rectangles narrow nothing: a test without divisions comes first.
TINTREE_CLONES void clip_rect(const SampleRect& samples, const RectTriangle& triangle, float bound, bool light,
                              float& lo, float& hi) {
  if (light) {
    if (narrows<true>(samples, triangle, bound, lo, hi)) narrow<true>(samples, triangle, bound, lo, hi);
  } else {
    if (narrows<false>(samples, triangle, bound, lo, hi)) narrow<false>(samples, triangle, bound, lo, hi);
  }
}

TINTREE_CLONES bool rect_within(const SampleRect& samples, const RectTriangle& triangle, float bound) {
  LaneInts bad = {};
  for_each_eight<3>(samples, triangle,
                    [&](const LaneInts& here, const Lanes&, const Lanes& residual)
                        TINTREE_INLINE_LAMBDA { bad |= here & ~((residual <= bound) & (residual >= -bound)); });
  return !any(bad);
}

}  // namespace tintree::simplify
