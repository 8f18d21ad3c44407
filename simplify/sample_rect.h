#pragma once

#include <array>
#include <cstdint>

namespace tintree::simplify {

/// What a rectangle of samples may have at most along each side.
inline constexpr int kMaxRectSamples = 32;

/// A rectangle of samples inside one block: rows are cache::kBlockStride apart and at least 7 more floats are
/// readable beyond each.
struct SampleRect {
  const float* heights;
  int columns;
  int rows;
};

/// A function of the place that is linear in the plane: value at the rectangle's first sample, steps from column to
/// column and from row to row.
template <typename Number>
struct Linear {
  Number start;
  Number per_column;
  Number per_row;
};

/// A triangle as it lies over a rectangle of samples.
struct RectTriangle {
  Linear<double> height;  ///< Of its plane, relative to the samples' base.
  Linear<double> weight;  ///< The hub's, 1 at the hub and 0 on the opposite side.
  /// Twice the areas against the three sides, in whatever whole units: none is negative inside. The first two are
  /// the sides at the hub, the third is opposite to it.
  std::array<Linear<std::int32_t>, 3> sides;
};

/// Intersects [lo, hi], hub heights relative to the plane's, with what each of the samples in the triangle allows
/// that have any weight. Missing samples (NaN) allow everything. In float: rounding is as of the largest height,
/// relative to the base, and weight that the plane has over the rectangle. `light`: there may be samples so near the
/// side opposite to the hub that the hub cannot move them; one beyond the bound makes the interval empty. The inner
/// loop of the simplifier: eight samples at a time.
void clip_rect(const SampleRect& samples, const RectTriangle& triangle, float bound, bool light, float& lo, float& hi);

/// Whether every sample in the triangle or on its sides lies within the bound of its plane; false for missing ones.
bool rect_within(const SampleRect& samples, const RectTriangle& triangle, float bound);

}  // namespace tintree::simplify
