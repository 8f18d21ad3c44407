/// Runs of samples under a triangle.

#include "simplify/sample_spans.h"

#include <vector>

#include <gtest/gtest.h>

namespace tintree::simplify {
namespace {

/// A run on a triangle's outer edge, where the hub moves nothing, with one sample off by twice the bound.
TEST(ClipSpans, AllowsNothingBesideALightSampleBeyondTheBoundOfAnySize) {
  for (const float bound : {1e-20F, 1e-3F, 1.0F, 3e7F, 1e20F}) {
    SCOPED_TRACE(bound);
    std::vector<float> heights(20, 0.0F);
    const RowSteps steps{0, 0, bound, true};
    const RowSpan run{heights.data(), 5, 0, 0};
    float lo = -bound;
    float hi = bound;
    clip_spans(&run, 1, steps, lo, hi);
    EXPECT_LE(lo, hi);
    heights[3] = 2 * bound;
    clip_spans(&run, 1, steps, lo, hi);
    EXPECT_GT(lo, hi);
  }
}

}  // namespace
}  // namespace tintree::simplify
