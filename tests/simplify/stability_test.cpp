/// Where simplifiers fail: whole trees over adversarial terrains, from errors too small for the format to errors
/// far beyond the relief, checked tile by tile on the stored bytes by brute force.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "simplify/tin_maker.h"
#include "tests/simplify/support.h"
#include "tests/simplify/whole_tree.h"
#include "tests/support/adversarial_terrain.h"
#include "tests/support/temp_dir.h"

namespace tintree::test {
namespace {

/// Whether the samples are those of one plane, all of them, as far as doubles tell.
bool is_planar(const HeightGrid& grid) {
  const double a = grid.at(1, 0) - grid.at(0, 0);
  const double b = grid.at(0, 1) - grid.at(0, 0);
  const double slack = 1e-12 * relief_m(grid);
  for (std::int64_t r = 0; r < grid.rows; ++r) {
    for (std::int64_t c = 0; c < grid.columns; ++c) {
      const double plane = grid.at(0, 0) + a * static_cast<double>(c) + b * static_cast<double>(r);
      if (!(std::abs(grid.at(c, r) - plane) <= slack)) return false;
    }
  }
  return true;
}

Terrain open_valid_terrain(const AdversarialTerrain& shape) {
  Terrain terrain = open_terrain(shape);
  EXPECT_EQ(terrain.surface->has_surface(), half_cells(terrain.grid, {0, 0, shape.columns - 1, shape.rows - 1}) > 0);
  return terrain;
}

/// Builds and checks a tree; a plane has to end at two triangles a tile.
void expect_stable(const Terrain& terrain, int tile_cells, double wished_error_m, const std::string& effort = "fast",
                   int levels_per_doubling = 1) {
  const double error_m = accepted_error_m(terrain, tile_cells, wished_error_m);
  SCOPED_TRACE(testing::Message() << "tile " << tile_cells << ", error " << error_m << " m");
  if (testing::Test::HasFailure()) return;
  const TempDir dir;
  const auto tree = build_whole_tree(terrain, make_layout(terrain, tile_cells, error_m, levels_per_doubling),
                                     dir.file("t.tintree"), effort);
  ASSERT_TRUE(tree.has_value()) << tree.error().text();
  expect_sound_tree(terrain, *tree);
  if (!is_planar(terrain.grid)) return;
  for (const simplify::LevelSummary& level : tree->levels) {
    EXPECT_EQ(level.triangles, 2 * level.tiles) << "a plane, level " << level.level;
  }
}

enum class ErrorSize { kTiny, kSmall, kNatural, kLarge, kHuge };

double error_m(ErrorSize size, const Terrain& terrain) {
  const cache::RasterInfo& info = terrain.surface->blocks().source().info();
  const double relief = relief_m(terrain.grid);
  switch (size) {
    case ErrorSize::kTiny:
      return 1e-13 * relief;  // refused: the least that is accepted takes its place
    case ErrorSize::kSmall:
      return 1e-4 * relief;
    case ErrorSize::kNatural:
      return std::sqrt(info.dx_m * info.dy_m) / 2;
    case ErrorSize::kLarge:
      return relief / 4;
    case ErrorSize::kHuge:
      return 1e5 * relief;
  }
  return 0;
}

class StabilityTest : public testing::TestWithParam<AdversarialTerrain> {};

TEST_P(StabilityTest, KeepsItsPromisesAtEveryError) {
  const AdversarialTerrain& shape = GetParam();
  SCOPED_TRACE(shape.about);
  const Terrain terrain = open_valid_terrain(shape);
  if (!terrain.surface->has_surface()) return;  // refused before any tile is made
  const int tile_cells = shape.columns > 200 ? 64 : shape.columns > 100 ? 32 : 16;
  for (const ErrorSize size :
       {ErrorSize::kTiny, ErrorSize::kSmall, ErrorSize::kNatural, ErrorSize::kLarge, ErrorSize::kHuge}) {
    expect_stable(terrain, tile_cells, error_m(size, terrain));
  }
}

TEST_P(StabilityTest, KeepsItsPromisesAtTheBestEffort) {
  const AdversarialTerrain& shape = GetParam();
  const Terrain terrain = open_valid_terrain(shape);
  if (!terrain.surface->has_surface()) return;
  // At this error leaves have vertices on half samples, and upper levels have not.
  const cache::RasterInfo& info = terrain.surface->blocks().source().info();
  expect_stable(terrain, 32, 0.2 * std::sqrt(info.dx_m * info.dy_m), "best");
}

INSTANTIATE_TEST_SUITE_P(Terrains, StabilityTest, testing::ValuesIn(adversarial_terrains()),
                         [](const auto& shape) { return shape.param.name; });

TEST(Stability, KnowsAPlane) {
  const auto planar = [](const AdversarialTerrain& shape) {
    return is_planar(make_exact_terrain(shape.columns, shape.rows, shape.height).grid);
  };
  EXPECT_EQ(std::ranges::count_if(adversarial_terrains(), planar), 7);
}

/// A number from the environment, for longer hunts than the ordinary run's.
unsigned from_environment(const char* name, unsigned otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<unsigned>(std::strtoul(text, nullptr, 10));
}

/// Random rasters at random errors. TINTREE_FUZZ_CASES and TINTREE_FUZZ_SEED choose how many and the first.
class StabilityFuzzTest : public testing::TestWithParam<unsigned> {};

constexpr unsigned kBatches = 8;

TEST_P(StabilityFuzzTest, KeepsItsPromises) {
  const unsigned cases = from_environment("TINTREE_FUZZ_CASES", 320) / kBatches;
  const unsigned first = from_environment("TINTREE_FUZZ_SEED", 1) + GetParam() * cases;
  for (unsigned seed = first; seed < first + cases && !HasFailure(); ++seed) {
    SCOPED_TRACE("make_terrain random_" + std::to_string(seed));
    const Terrain terrain = open_valid_terrain(random_terrain(seed));
    if (!terrain.surface->has_surface()) continue;
    const double share = std::pow(10.0, 7 * noise(static_cast<int>(seed), 0) - 5);
    expect_stable(terrain, 8 << (seed % 3), share * relief_m(terrain.grid), "fast", seed % 4 == 0 ? 2 : 1);
  }
}

/// Whatever its slope, the raster's size and the error, a plane ends at two triangles a tile.
TEST_P(StabilityFuzzTest, EndsPlanesAtTwoTriangles) {
  const unsigned cases = from_environment("TINTREE_FUZZ_CASES", 320) / (4 * kBatches);
  const unsigned first = from_environment("TINTREE_FUZZ_SEED", 1) + GetParam() * cases;
  for (unsigned seed = first; seed < first + cases && !HasFailure(); ++seed) {
    const auto random = [&](int k) { return noise(static_cast<int>(seed), k, 7); };
    const auto slope = [&](int k) { return (random(k) - 0.5) * std::pow(10.0, 8 * random(k + 1) - 4); };
    const double a = slope(1);
    const double b = slope(3);
    const double c = slope(5);
    const auto plane = [&](int column, int row) { return a * column + b * row + c; };
    const Terrain terrain =
        make_exact_terrain(2 + static_cast<int>(150 * random(7)), 2 + static_cast<int>(150 * random(8)), plane);
    const int tile_cells = 8 << (seed % 4);
    const double error_m =
        accepted_error_m(terrain, tile_cells, relief_m(terrain.grid) * std::pow(10.0, 8 * random(9) - 7));
    SCOPED_TRACE(testing::Message() << "seed " << seed << ": " << a << " c + " << b << " r + " << c << ", "
                                    << terrain.grid.columns << " x " << terrain.grid.rows << ", tile " << tile_cells
                                    << ", error " << error_m << " m");
    const codec::TreeLayout layout = make_layout(terrain, tile_cells, error_m);
    simplify::TinMaker maker(*terrain.surface, layout);
    for (const codec::TileId& id : tiles_of(layout)) {
      const auto mesh = maker.make(id);
      ASSERT_TRUE(mesh.has_value()) << mesh.error().text();
      ASSERT_EQ(mesh->triangles.size(), 2U) << "tile " << id.text();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Batches, StabilityFuzzTest, testing::Range(0U, kBatches));

}  // namespace
}  // namespace tintree::test
