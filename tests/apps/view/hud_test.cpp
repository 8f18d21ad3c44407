#include "apps/view/hud.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace tintree::view {
namespace {

TEST(Hud, TheStatisticsLineHasEveryFigure) {
  const auto parts = figures_text({.frame_seconds = 0.0164,
                                   .frames_per_second = 58,
                                   .triangles = 123456,
                                   .tiles = 41,
                                   .culled = 17,
                                   .occluded = 23,
                                   .hits = 30,
                                   .misses = 10,
                                   .cache_bytes = 5'000'000,
                                   .gpu_bytes = 7'000'000,
                                   .max_error_px = 0.75,
                                   .allowed_px = 1,
                                   .to_come = 3});
  for (const char* part : {"58 fps", "16.4 ms", "123456 triangles", "41 tiles", "17 out of view", "23 hidden",
                           "error 0.75 of 1 px", "cache hits 75 %", "memory 5 MB + 7 MB graphics", "3 tiles to come"})
    EXPECT_NE(std::ranges::find(parts, part), parts.end()) << part;
  EXPECT_EQ(figures_text({}).front(), "at rest");
}

}  // namespace
}  // namespace tintree::view
