#include "apps/view/view_options.h"

#include <numbers>

#include <gtest/gtest.h>

namespace tintree::view {
namespace {

CommandLine line() {
  CommandLine out;
  out.trees = {"dem.tintree"};
  return out;
}

TEST(ViewOptions, ReadTheSunAndWhatToShow) {
  CommandLine given = line();
  given.sun = "90,30.5";
  given.show = {"levels", "boxes", "triangles"};
  const auto options = read_options(given);
  ASSERT_TRUE(options) << options.error().text();
  EXPECT_DOUBLE_EQ(options->style.sun_azimuth_rad, std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(options->style.sun_elevation_rad, 30.5 * std::numbers::pi / 180);
  EXPECT_EQ(options->style.tint, render::Tint::kLevel);
  EXPECT_TRUE(options->boxes);
  EXPECT_TRUE(options->style.wireframe);
  EXPECT_FALSE(read_options(line())->boxes);
  EXPECT_EQ(read_options(line())->style.tint, render::Tint::kHeight);
}

TEST(ViewOptions, NameWhatMakesNoSense) {
  for (const char* sun : {"315", "315,91", "315,-1", "north,30", "315,30,", "nan,30", "1e9,30"}) {
    CommandLine given = line();
    given.sun = sun;
    const auto options = read_options(given);
    ASSERT_FALSE(options) << sun;
    EXPECT_EQ(options.error().code, ErrorCode::kUsage);
    EXPECT_EQ(options.error().where, "--sun");
  }
  CommandLine given = line();
  given.show = {"levels", "heights"};
  ASSERT_FALSE(read_options(given));
  EXPECT_EQ(read_options(given).error().where, "--show");
}

}  // namespace
}  // namespace tintree::view
