#include "simplify/border_places.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"

namespace tintree::simplify {
namespace {

using test::Terrain;

LevelGrid level_of(std::int64_t cells, double bound_m) { return {cells, bound_m, {bound_m / 4}}; }

std::vector<std::int32_t> places(const Terrain& terrain, const LevelGrid& level, const Side& side) {
  SurfaceView view(*terrain.surface);
  return border_places(view, level, side);
}

TEST(BorderPlaces, OfAPlaneAreEightPieces) {
  const Terrain plane = test::make_terrain(129, 129, [](int c, int r) { return 2.0 * c - r; });
  const std::vector<std::int32_t> eighths{0, 8, 16, 24, 32, 40, 48, 56, 64};
  for (const bool southward : {false, true})
    EXPECT_EQ(places(plane, level_of(64, 1), {64, 64, 64, southward}), eighths);
}

TEST(BorderPlaces, HoldHalfTheBoundAlongTheSide) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    const Terrain rough = test::make_terrain(129, 129, test::rough_hills(40, 4, 0, seed));
    for (const bool southward : {false, true}) {
      const double bound_m = 0.5 * std::pow(2.0, seed);
      const LevelGrid level = level_of(64, bound_m);
      const auto found = places(rough, level, {64, 0, 64, southward});
      ASSERT_EQ(found.front(), 0);
      ASSERT_EQ(found.back(), 64);
      const auto height = [&](std::int32_t at) {
        return southward ? rough.grid.at(64, at) : rough.grid.at(64 + at, 0);
      };
      for (std::size_t k = 1; k < found.size(); ++k) {
        const std::int32_t a = found[k - 1];
        const std::int32_t b = found[k];
        ASSERT_GT(b, a);
        EXPECT_EQ((b - a) & (b - a - 1), 0) << "pieces are powers of two";
        EXPECT_EQ(a % (b - a), 0) << "and lie at multiples of themselves";
        if (b - a == 1) continue;
        for (std::int32_t at = a; at <= b; ++at) {
          const double share = static_cast<double>(at - a) / (b - a);
          const double line = level.heights.snapped_m(height(a)) +
                              share * (level.heights.snapped_m(height(b)) - level.heights.snapped_m(height(a)));
          EXPECT_LE(std::abs(line - height(at)), bound_m / 2) << at;
        }
      }
    }
  }
}

/// What lies two rows from the side and further does not matter, so that the tile beyond gets the same.
TEST(BorderPlaces, DependOnTheRowsNextToTheSideAlone) {
  const auto hills = test::rough_hills(30, 2, 0.002, 3);
  const Terrain one = test::make_terrain(129, 65, hills);
  const Terrain other = test::make_terrain(
      129, 65, [&](int c, int r) { return std::abs(r - 32) <= 1 ? hills(c, r) : 5.0 * ((c * 7 + r * 3) % 11); });
  const Side side{32, 32, 32, false};
  EXPECT_EQ(places(one, level_of(32, 3), side), places(other, level_of(32, 3), side));
}

TEST(BorderPlaces, AreEverySampleNextToAHole) {
  const Terrain holed =
      test::make_terrain(129, 129, [](int c, int r) { return c == 70 && r == 65 ? test::kMissing : 1.0; });
  const auto found = places(holed, level_of(64, 1), {64, 64, 64, false});
  // No piece of more than a cell reaches place 6.
  EXPECT_EQ(found, (std::vector<std::int32_t>{0, 4, 5, 6, 7, 8, 16, 24, 32, 40, 48, 56, 64}));
}

TEST(BorderPlaces, AreEverySampleBesideAStripOneCellWide) {
  const Terrain narrow = test::make_terrain(65, 66, [](int, int) { return 1.0; });
  EXPECT_EQ(places(narrow, level_of(64, 1), {0, 64, 64, false}).size(), 65U);
  EXPECT_EQ(places(narrow, level_of(64, 1), {0, 0, 64, false}).size(), 9U);
}

TEST(BorderPlaces, EndWithTheRaster) {
  const Terrain cut = test::make_terrain(101, 101, [](int, int) { return 1.0; });
  const auto found = places(cut, level_of(64, 1), {64, 64, 64, true});
  EXPECT_EQ(found, (std::vector<std::int32_t>{0, 8, 16, 24, 32, 36}));
}

}  // namespace
}  // namespace tintree::simplify
