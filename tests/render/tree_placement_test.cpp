#include "render/tree_placement.h"

#include <cmath>

#include <gtest/gtest.h>

#include "cache/drawable_tile.h"

namespace tintree::render {
namespace {

cache::Manifest manifest(std::int64_t columns, std::int64_t rows, const std::array<double, 6>& geotransform) {
  cache::Manifest m;
  m.crs_wkt = "PROJCS";
  m.geotransform = geotransform;
  m.layout.columns = columns;
  m.layout.rows = rows;
  m.layout.dx_m = std::hypot(geotransform[1], geotransform[4]);
  m.layout.dy_m = std::hypot(geotransform[2], geotransform[5]);
  m.layout.axes = {{geotransform[1] / m.layout.dx_m, geotransform[4] / m.layout.dx_m},
                   {geotransform[2] / m.layout.dy_m, geotransform[5] / m.layout.dy_m}};
  return m;
}

/// World position of a sample in the scene.
std::array<double, 2> place(const PlacedTree& tree, double column, double row) {
  return tree.layout.world(column, row);
}

TEST(TreePlacement, ATreeByItselfLiesAsItIs) {
  const cache::Manifest m = manifest(11, 21, {5e5, 10, 0, 4e6, 0, -10});
  const auto placed = place_trees(std::vector<TreeToPlace>{{&m, "a"}});
  ASSERT_TRUE(placed);
  EXPECT_EQ(placed->front().layout.origin_m, (std::array<double, 2>{0, 0}));
  EXPECT_EQ(placed->front().layout.dx_m, 10);
  EXPECT_EQ(placed->front().joined_sides, 0);
}

// Four pieces of one raster that share the samples on the cuts.
TEST(TreePlacement, PiecesOfOneRasterMeetAndKnowTheirNeighbours) {
  const cache::Manifest nw = manifest(11, 21, {5e5, 10, 0, 4e6, 0, -10});
  const cache::Manifest ne = manifest(31, 21, {5e5 + 100, 10, 0, 4e6, 0, -10});
  const cache::Manifest sw = manifest(11, 5, {5e5, 10, 0, 4e6 - 200, 0, -10});
  const cache::Manifest se = manifest(31, 5, {5e5 + 100, 10, 0, 4e6 - 200, 0, -10});
  const auto placed = place_trees(std::vector<TreeToPlace>{{&nw, "a"}, {&ne, "b"}, {&sw, "c"}, {&se, "d"}});
  ASSERT_TRUE(placed);
  EXPECT_EQ(place((*placed)[1], 0, 7), place((*placed)[0], 10, 7));
  EXPECT_EQ(place((*placed)[2], 3, 0), place((*placed)[0], 3, 20));
  EXPECT_EQ(place((*placed)[3], 0, 0), place((*placed)[0], 10, 20));
  using namespace cache;
  EXPECT_EQ((*placed)[0].joined_sides, kSkirtEast | kSkirtSouth);
  EXPECT_EQ((*placed)[1].joined_sides, kSkirtWest | kSkirtSouth);
  EXPECT_EQ((*placed)[2].joined_sides, kSkirtEast | kSkirtNorth);
  EXPECT_EQ((*placed)[3].joined_sides, kSkirtWest | kSkirtNorth);
}

TEST(TreePlacement, TreesApartHaveNoJoinedSides) {
  const cache::Manifest a = manifest(11, 21, {5e5, 10, 0, 4e6, 0, -10});
  const cache::Manifest b = manifest(11, 21, {5e5 + 1000, 10, 0, 4e6, 0, -10});
  const auto placed = place_trees(std::vector<TreeToPlace>{{&a, "a"}, {&b, "b"}});
  ASSERT_TRUE(placed);
  EXPECT_EQ(place((*placed)[1], 0, 0), (std::array<double, 2>{1000, 0}));
  EXPECT_EQ((*placed)[0].joined_sides | (*placed)[1].joined_sides, 0);
}

// In degrees each tree has metres of its own; in the scene those of the first hold, and another spacing stays another.
TEST(TreePlacement, DegreesHaveOneLengthInAScene) {
  const double a_m = 111000 * std::cos(0.6);
  const double b_m = 111000 * std::cos(0.7);
  cache::Manifest a = manifest(11, 21, {-120, 0.01, 0, 36, 0, -0.01});
  a.layout.dx_m = 0.01 * a_m;
  a.layout.dy_m = 0.01 * 111000;
  cache::Manifest b = manifest(41, 21, {-119.9, 0.0025, 0, 36.2, 0, -0.0025});
  b.layout.dx_m = 0.0025 * b_m;
  b.layout.dy_m = 0.0025 * 111100;
  const auto placed = place_trees(std::vector<TreeToPlace>{{&a, "a"}, {&b, "b"}});
  ASSERT_TRUE(placed);
  // The centre of b's sample (20, 20) in degrees, in a's metres from the centre of a's first sample.
  const double lon = -119.9 + 20.5 * 0.0025 - (-120 + 0.005);
  const double lat = 36.2 - 20.5 * 0.0025 - (36 - 0.005);
  EXPECT_NEAR(place((*placed)[1], 20, 20)[0], lon * a_m, 1e-6);
  EXPECT_NEAR(place((*placed)[1], 20, 20)[1], lat * 111000, 1e-6);
}

TEST(TreePlacement, ARotatedTreeKeepsItsDirection) {
  const double c = 8;
  const double s = 6;
  const cache::Manifest a = manifest(11, 11, {100, c, s, 200, s, -c});
  // What begins at the sample (10, 0) of the first.
  const cache::Manifest b = manifest(11, 11, {100 + 10 * c, c, s, 200 + 10 * s, s, -c});
  const auto placed = place_trees(std::vector<TreeToPlace>{{&a, "a"}, {&b, "b"}});
  ASSERT_TRUE(placed);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(place((*placed)[1], 0, 4)[i], place((*placed)[0], 10, 4)[i], 1e-9);
  }
  EXPECT_EQ((*placed)[0].joined_sides, cache::kSkirtEast);
  EXPECT_EQ((*placed)[1].joined_sides, cache::kSkirtWest);
}

TEST(TreePlacement, RefusesAnotherCrs) {
  const cache::Manifest a = manifest(11, 21, {5e5, 10, 0, 4e6, 0, -10});
  cache::Manifest b = a;
  b.crs_wkt = "GEOGCS";
  const auto placed = place_trees(std::vector<TreeToPlace>{{&a, "a.tintree"}, {&b, "b.tintree"}});
  ASSERT_FALSE(placed);
  EXPECT_EQ(placed.error().code, ErrorCode::kBadData);
  EXPECT_EQ(placed.error().where, "b.tintree");
  EXPECT_NE(placed.error().message.find("gdalwarp"), std::string::npos);
}

}  // namespace
}  // namespace tintree::render
