#include "simplify/sample_spans.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

namespace tintree::simplify {
namespace {

/// Below this weight the hub cannot move a point measurably: it lies on the old outer edge or hard by it.
constexpr float kMinWeight = 1e-6F;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Eight floats at a time; compiled once for the machine's baseline and once for AVX2.
#define TINTREE_CLONES __attribute__((target_clones("avx2", "default")))
using Lanes = float __attribute__((vector_size(32)));
using LaneMask = std::int32_t __attribute__((vector_size(32)));
constexpr int kLanes = 8;

}  // namespace

TINTREE_CLONES void clip_spans(const RowSpan* spans, int count, const RowSteps& steps, float& lo, float& hi) {
  const Lanes iota = {0, 1, 2, 3, 4, 5, 6, 7};
  Lanes best_lo = iota * 0 + lo;
  Lanes best_hi = iota * 0 + hi;
  const Lanes nothing = iota * 0 + kInfinity;
  for (int k = 0; k < count; ++k) {
    const RowSpan& span = spans[k];
    const auto n = static_cast<float>(span.n);
    for (int i = 0; i < span.n; i += kLanes) {
      const Lanes at = iota + static_cast<float>(i);
      const Lanes weight = span.weight + at * steps.weight;
      Lanes h;
      std::memcpy(&h, span.heights + i, sizeof h);
      const Lanes residual = h - (span.plane + at * steps.plane);
      const Lanes inverse = 1.0F / weight;
      const Lanes low = (residual - steps.bound) * inverse;
      const Lanes high = (residual + steps.bound) * inverse;
      const LaneMask counts = (at < n) & (weight > kMinWeight);
      const LaneMask raises = counts & (low > best_lo);
      const LaneMask lowers = counts & (high < best_hi);
      best_lo = raises ? low : best_lo;
      best_hi = lowers ? high : best_hi;
      if (steps.light) {
        const LaneMask beyond =
            (at < n) & (weight <= kMinWeight) & ((residual > steps.bound) | (residual < -steps.bound));
        best_lo = beyond ? nothing : best_lo;
      }
    }
  }
  for (int i = 0; i < kLanes; ++i) {
    lo = std::max(lo, best_lo[i]);
    hi = std::min(hi, best_hi[i]);
  }
}

TINTREE_CLONES bool span_within(const RowSpan& span, const RowSteps& steps) {
  const Lanes iota = {0, 1, 2, 3, 4, 5, 6, 7};
  const auto n = static_cast<float>(span.n);
  LaneMask bad = {};
  for (int i = 0; i < span.n; i += kLanes) {
    const Lanes at = iota + static_cast<float>(i);
    Lanes h;
    std::memcpy(&h, span.heights + i, sizeof h);
    const Lanes residual = h - (span.plane + at * steps.plane);
    bad |= (at < n) & ~((residual <= steps.bound) & (residual >= -steps.bound));
  }
  int any = 0;
  for (int i = 0; i < kLanes; ++i) any |= bad[i];
  return any == 0;
}

}  // namespace tintree::simplify
