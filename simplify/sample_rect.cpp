#include "simplify/sample_rect.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "cache/height_blocks.h"
#include "codec/target_clones.h"

namespace tintree::simplify {
namespace {

/// Below this weight the hub cannot move a point measurably: it lies on the old outer edge or hard by it.
constexpr float kMinWeight = 1e-6F;

// Eight numbers at a time.
#define TINTREE_INLINE __attribute__((always_inline)) inline
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

/// The sides' areas along one row, eight at a time.
template <int kSides>
struct RowSides {
  LaneInts area[kSides] = {};
  std::int32_t step[kSides] = {};

  TINTREE_INLINE RowSides(const RectTriangle& t, int row) {
    for (int k = 0; k < kSides; ++k) {
      const Linear<std::int32_t>& side = t.sides[static_cast<std::size_t>(k)];
      area[k] = (side.start + row * side.per_row) + kIotaInt * side.per_column;
      step[k] = kLanes * side.per_column;
    }
  }
  /// Clears what is outside in `mask`; moves on to the next eight.
  TINTREE_INLINE void clip(LaneInts& mask) {
    LaneInts signs = area[0];
    area[0] += step[0];
    for (int k = 1; k < kSides; ++k) {
      signs |= area[k];
      area[k] += step[k];
    }
    mask &= signs >= 0;
  }
};

/// Whether any sample narrows the interval.
template <bool kLight>
TINTREE_INLINE bool narrows(const SampleRect& samples, const RectTriangle& t, float bound, float lo, float hi) {
  LaneInts found = {};
  const auto columns = static_cast<float>(samples.columns);
  const auto weight_step = static_cast<float>(t.weight.per_column);
  const auto height_step = static_cast<float>(t.height.per_column);
  for (int j = 0; j < samples.rows; ++j) {
    const float* row = samples.heights + j * cache::kBlockStride;
    RowSides<kLight ? 3 : 2> sides(t, j);
    const auto weight_start = static_cast<float>(t.weight.start + j * t.weight.per_row);
    const auto height_start = static_cast<float>(t.height.start + j * t.height.per_row);
    for (int i = 0; i < samples.columns; i += kLanes) {
      const Lanes at = kIota + static_cast<float>(i);
      const Lanes weight = weight_start + at * weight_step;
      Lanes h;
      std::memcpy(&h, row + i, sizeof h);
      const Lanes residual = h - (height_start + at * height_step);
      LaneInts here = at < columns;
      sides.clip(here);
      const LaneInts beyond = (residual - bound > lo * weight) | (residual + bound < hi * weight);
      found |= here & beyond & (weight > kMinWeight);
      if (kLight) found |= here & (weight <= kMinWeight) & ((residual > bound) | (residual < -bound));
    }
  }
  return any(found);
}

template <bool kLight>
TINTREE_INLINE void narrow(const SampleRect& samples, const RectTriangle& t, float bound, float& lo, float& hi) {
  Lanes best_lo = kIota * 0 + lo;
  Lanes best_hi = kIota * 0 + hi;
  const auto columns = static_cast<float>(samples.columns);
  const auto weight_step = static_cast<float>(t.weight.per_column);
  const auto height_step = static_cast<float>(t.height.per_column);
  for (int j = 0; j < samples.rows; ++j) {
    const float* row = samples.heights + j * cache::kBlockStride;
    RowSides<kLight ? 3 : 2> sides(t, j);
    const auto weight_start = static_cast<float>(t.weight.start + j * t.weight.per_row);
    const auto height_start = static_cast<float>(t.height.start + j * t.height.per_row);
    for (int i = 0; i < samples.columns; i += kLanes) {
      const Lanes at = kIota + static_cast<float>(i);
      const Lanes weight = weight_start + at * weight_step;
      Lanes h;
      std::memcpy(&h, row + i, sizeof h);
      const Lanes residual = h - (height_start + at * height_step);
      LaneInts here = at < columns;
      sides.clip(here);
      const Lanes low = (residual - bound) / weight;
      const Lanes high = (residual + bound) / weight;
      const LaneInts counts = here & (weight > kMinWeight);
      best_lo = counts & (low > best_lo) ? low : best_lo;
      best_hi = counts & (high < best_hi) ? high : best_hi;
      if (kLight) {
        const LaneInts stuck = here & (weight <= kMinWeight) & ((residual > bound) | (residual < -bound));
        best_lo = stuck ? (kIota - kIota) + kUnreachable : best_lo;
      }
    }
  }
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

TINTREE_CLONES bool rect_within(const SampleRect& samples, const RectTriangle& t, float bound) {
  LaneInts bad = {};
  const auto columns = static_cast<float>(samples.columns);
  const auto height_step = static_cast<float>(t.height.per_column);
  for (int j = 0; j < samples.rows; ++j) {
    const float* row = samples.heights + j * cache::kBlockStride;
    RowSides<3> sides(t, j);
    const auto height_start = static_cast<float>(t.height.start + j * t.height.per_row);
    for (int i = 0; i < samples.columns; i += kLanes) {
      const Lanes at = kIota + static_cast<float>(i);
      Lanes h;
      std::memcpy(&h, row + i, sizeof h);
      const Lanes residual = h - (height_start + at * height_step);
      LaneInts here = at < columns;
      sides.clip(here);
      bad |= here & ~((residual <= bound) & (residual >= -bound));
    }
  }
  return !any(bad);
}

}  // namespace tintree::simplify
