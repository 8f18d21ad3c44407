/// Whole trees of method `strip`, checked on the stored bytes by brute force.

#include "simplify/strip_maker.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"
#include "tests/simplify/whole_tree.h"
#include "tests/support/adversarial_terrain.h"

namespace tintree::test {
namespace {

class StripMakerTest : public testing::TestWithParam<AdversarialTerrain> {};

TEST_P(StripMakerTest, KeepsItsPromises) {
  const AdversarialTerrain& shape = GetParam();
  SCOPED_TRACE(shape.about);
  const Terrain terrain = open_terrain(shape);
  if (!terrain.surface->has_surface()) return;
  const cache::RasterInfo& info = terrain.surface->blocks().source().info();
  const double spacing_m = std::sqrt(info.dx_m * info.dy_m);
  expect_sound_build(terrain, shape.columns > 100 ? 32 : 16, spacing_m / 2, "strip", "fast");
  expect_sound_build(terrain, 64, spacing_m / 50, "strip", "best");
}

INSTANTIATE_TEST_SUITE_P(Terrains, StripMakerTest, testing::ValuesIn(adversarial_terrains()),
                         [](const auto& shape) { return shape.param.name; });

TEST(StripMaker, CountsHeightsInHalvesOfTheBound) {
  const Terrain terrain = make_terrain(129, 129, rough_hills(30, 1, 0, 5));
  const codec::TreeLayout layout = make_layout(terrain, 128, 2);
  simplify::StripMaker maker(*terrain.surface, layout);
  const auto mesh = maker.make({0, 0, 0});
  ASSERT_TRUE(mesh.has_value());
  ASSERT_FALSE(mesh->vertices.empty());
  for (const codec::GridVertex& v : mesh->vertices) {
    const double height_m = static_cast<double>(mesh->z_offset + v.z) * layout.z_step_m[0];
    EXPECT_EQ(height_m, std::round(height_m)) << "half of 2 m";
  }
}

}  // namespace
}  // namespace tintree::test
