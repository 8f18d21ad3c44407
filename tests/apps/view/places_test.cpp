#include "apps/view/places.h"

#include <gtest/gtest.h>

namespace tintree::view {
namespace {

cache::Manifest utm() {
  cache::Manifest m;
  m.layout.columns = 101;
  m.layout.rows = 51;
  m.layout.dx_m = m.layout.dy_m = 30;
  m.geotransform = {500000, 30, 0, 4600000, 0, -30};
  return m;
}

TEST(Places, CoordinatesOfSamplesAreTheirPixelsCentres) {
  const cache::Manifest m = utm();
  EXPECT_NEAR(crs_coordinates(m, {0, 0, 0})[0], 500015, 1e-9);
  EXPECT_NEAR(crs_coordinates(m, {0, 0, 0})[1], 4599985, 1e-9);
  EXPECT_NEAR(crs_coordinates(m, {300, -60, 7})[0], 500315, 1e-9);
  EXPECT_NEAR(crs_coordinates(m, {300, -60, 7})[1], 4599925, 1e-9);
  EXPECT_EQ(place_text(m, {300, -60, 7.25}), "x 300.0 y -60.0 height 7.2 m · CRS 500315.00, 4599925.00");
}

TEST(Places, FollowsARotatedGrid) {
  // A quarter turn: columns run north, rows east.
  cache::Manifest m = utm();
  m.layout.axes = {{0, 1}, {1, 0}};
  m.geotransform = {500000, 0, 30, 4600000, 30, 0};
  // Ten columns on is 300 m north.
  EXPECT_NEAR(crs_coordinates(m, {0, 300, 0})[0], 500015, 1e-9);
  EXPECT_NEAR(crs_coordinates(m, {0, 300, 0})[1], 4600000 + 10.5 * 30, 1e-9);
}

TEST(Places, SaysDegreesForAGeographicGrid) {
  cache::Manifest m = utm();
  m.geographic = true;
  m.geotransform = {-84.4, 0.001, 0, 36.7, 0, -0.001};
  EXPECT_EQ(place_text(m, {0, 0, 100}), "x 0.0 y 0.0 height 100.0 m · 36.699500°N 84.399500°W");
}

}  // namespace
}  // namespace tintree::view
