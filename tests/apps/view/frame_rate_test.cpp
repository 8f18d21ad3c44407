#include "apps/view/frame_rate.h"

#include <gtest/gtest.h>

namespace tintree::view {
namespace {

TEST(FrameRate, CountsTheFramesSinceTheLastRest) {
  FrameRate rate;
  EXPECT_EQ(rate.per_second(), 0);
  rate.note_frame(5);
  EXPECT_EQ(rate.per_second(), 0) << "one frame has no rate";
  for (int i = 1; i <= 100; ++i) rate.note_frame(5 + 0.02 * i);
  EXPECT_NEAR(rate.per_second(), 50, 1e-6);
  // It follows what is drawn now, not what was; slow frames are no rest.
  for (int i = 1; i <= 100; ++i) rate.note_frame(7 + 0.5 * i);
  EXPECT_NEAR(rate.per_second(), 2, 1e-6);
  rate.rest();
  EXPECT_EQ(rate.per_second(), 0);
  rate.note_frame(100);
  rate.note_frame(100.05);
  EXPECT_NEAR(rate.per_second(), 20, 1e-6) << "the rest is no frame's time";
}

}  // namespace
}  // namespace tintree::view
