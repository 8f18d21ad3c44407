#include "apps/audit/mesh_heights.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/regular_tree.h"
#include "tests/support/temp_dir.h"

namespace tintree::audit {
namespace {

/// A mesh with a vertex at every sample is the surface itself, but for the height step.
TEST(MeshHeights, AreThoseOfTheSurfaceAtEveryPlace) {
  const test::TempDir dir;
  const std::string path = dir.file("dem.tif");
  test::write_raster(path, {.columns = 50, .rows = 41}, [](int c, int r) {
    return c > 20 && c < 26 && r > 9 && r < 18 ? test::kMissing : test::hills(c, r);
  });
  const test::HeightGrid grid = test::read_grid(path);
  const test::TestTree tree = test::make_regular_tree(path, {.tile_cells = 16, .z_step_m = 1e-4, .xy_shift = -2});
  const codec::TileId id{1, 0, 0};
  const TileSurface surface = place(tree.manifest.layout, id, tree.mesh(id));
  const MeshHeights heights(surface);
  std::mt19937 random(1);
  std::uniform_real_distribution<> dice(0, 32);
  for (int i = 0; i < 3000; ++i) {
    const bool on_sample = i % 3 == 0;
    const double c = on_sample ? std::round(dice(random)) : dice(random);
    const double r = on_sample ? std::round(dice(random)) : dice(random);
    const double expected = grid.surface(c, r);
    if (std::isnan(expected) && on_sample) continue;  // on a hole's outline either answer is right
    if (std::isnan(expected)) {
      EXPECT_TRUE(std::isnan(heights.at(c, r))) << c << ' ' << r;
    } else {
      EXPECT_NEAR(heights.at(c, r), expected, 1e-4) << c << ' ' << r;
    }
  }
}

}  // namespace
}  // namespace tintree::audit
