#pragma once

namespace tintree::simplify {

/// A run of samples of one row under a triangle: n samples from `heights` (at least 7 more floats must be
/// readable beyond them); hub weight and plane height, relative to the samples' base, at the first one.
struct RowSpan {
  const float* heights;
  int n;
  float weight;
  float plane;
};

/// What the runs of a triangle share: the steps of weight and plane from sample to sample, and the bound.
struct RowSteps {
  float weight;
  float plane;
  float bound;
  bool light = false;  // there may be samples hard by the outer edge
};

/// Intersects [lo, hi], hub heights relative to the plane's, with what each sample of the runs allows. Missing
/// samples (NaN) allow everything. The inner loop of the simplifier: eight samples at a time.
void clip_spans(const RowSpan* spans, int count, const RowSteps& steps, float& lo, float& hi);

/// Whether every sample of the run lies within the bound of the plane; false for missing ones too.
bool span_within(const RowSpan& span, const RowSteps& steps);

}  // namespace tintree::simplify
