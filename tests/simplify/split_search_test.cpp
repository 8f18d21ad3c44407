/// The flags against the triangles that they stand for, walked from the squares down.

#include "simplify/split_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"
#include "tests/support/adversarial_terrain.h"

namespace tintree::simplify {
namespace {

using test::AdversarialTerrain;
using test::Terrain;

struct GridPoint {
  std::int64_t x;
  std::int64_t y;
};

LevelGrid level_of(std::int64_t cells, double bound_m) { return {cells, bound_m, {bound_m / 4}}; }

/// The flags of one tile's window.
struct Window {
  LevelGrid level;
  std::int64_t column0;
  std::int64_t row0;
  SplitFlags flags;

  Window(const Terrain& terrain, const LevelGrid& grid, std::int64_t tile_x, std::int64_t tile_y)
      : level(grid), column0(tile_x * grid.cells - ring()), row0(tile_y * grid.cells - ring()), flags([&] {
          SurfaceView view(*terrain.surface);
          return find_splits(view, grid, tile_x * grid.cells, tile_y * grid.cells);
        }()) {}

  std::int64_t ring() const { return kRingSquares * level.square(); }
  std::int64_t span() const { return level.cells + 2 * ring(); }
  bool at(std::int64_t column, std::int64_t row) const { return flags.get(column - column0, row - row0); }
};

/// Visits triangle (hypotenuse a-b, apex c) and all that can come of it; `parent` is the middle of the triangle whose
/// half it is.
template <typename Visit>
void walk(GridPoint a, GridPoint b, GridPoint c, const GridPoint* parent, const Visit& visit) {
  if (std::abs(a.x - b.x) == 1 && std::abs(a.y - b.y) == 1) return;
  const GridPoint middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
  visit(middle, parent);
  walk(c, a, middle, &middle, visit);
  walk(b, c, middle, &middle, visit);
}

template <typename Visit>
void walk_window(std::int64_t span, std::int64_t square, const Visit& visit) {
  for (std::int64_t y = 0; y < span; y += square) {
    for (std::int64_t x = 0; x < span; x += square) {
      const GridPoint nw{x, y};
      const GridPoint ne{x + square, y};
      const GridPoint sw{x, y + square};
      const GridPoint se{x + square, y + square};
      const bool even = (x / square + y / square) % 2 == 0;
      walk(even ? nw : sw, even ? se : ne, even ? ne : nw, nullptr, visit);
      walk(even ? se : ne, even ? nw : sw, even ? sw : se, nullptr, visit);
    }
  }
}

/// A triangle whose middle is flagged exists: the triangle that it is half of is split too. Squares are never merged.
void expect_closed(const Window& w) {
  const std::int64_t square = w.level.square();
  for (std::int64_t y = 0; y <= w.span(); y += square) {
    for (std::int64_t x = 0; x <= w.span(); x += square) EXPECT_TRUE(w.flags.get(x, y)) << "a square's corner";
  }
  std::int64_t open = 0;
  walk_window(w.span(), square, [&](GridPoint middle, const GridPoint* parent) {
    if (parent != nullptr && w.flags.get(middle.x, middle.y) && !w.flags.get(parent->x, parent->y)) ++open;
  });
  EXPECT_EQ(open, 0) << "triangles that are split but do not exist";
}

/// Both windows decide alike wherever it matters to either tile: up to half a square's side beyond the common side.
void expect_agreement(const Window& a, const Window& b) {
  const std::int64_t reach = a.level.square() / 2;
  const auto own = [&](const Window& w, bool east) { return (east ? w.column0 : w.row0) + w.ring(); };
  // Each tile's square, widened; both together.
  const std::int64_t west = std::max(own(a, true), own(b, true)) - reach;
  const std::int64_t east = std::min(own(a, true), own(b, true)) + a.level.cells + reach;
  const std::int64_t north = std::max(own(a, false), own(b, false)) - reach;
  const std::int64_t south = std::min(own(a, false), own(b, false)) + a.level.cells + reach;
  std::int64_t differ = 0;
  for (std::int64_t r = north; r <= south; ++r) {
    for (std::int64_t c = west; c <= east; ++c) differ += a.at(c, r) != b.at(c, r) ? 1 : 0;
  }
  EXPECT_EQ(differ, 0) << "flags, between " << west << ' ' << north << " and " << east << ' ' << south;
}

void expect_sound_windows(const Terrain& terrain, std::int64_t cells, double bound_m) {
  SCOPED_TRACE("tiles of " + std::to_string(cells) + ", bound " + std::to_string(bound_m));
  const LevelGrid level = level_of(cells, bound_m);
  const std::int64_t across = std::min<std::int64_t>(3, (terrain.grid.columns - 2) / cells + 1);
  const std::int64_t down = std::min<std::int64_t>(2, (terrain.grid.rows - 2) / cells + 1);
  for (std::int64_t y = 0; y < down; ++y) {
    for (std::int64_t x = 0; x < across; ++x) {
      const Window here(terrain, level, x, y);
      expect_closed(here);
      if (x + 1 < across) expect_agreement(here, Window(terrain, level, x + 1, y));
      if (y + 1 < down) expect_agreement(here, Window(terrain, level, x, y + 1));
      if (x + 1 < across && y + 1 < down) expect_agreement(here, Window(terrain, level, x + 1, y + 1));
      if (testing::Test::HasFailure()) return;
    }
  }
}

class SplitSearchTest : public testing::TestWithParam<AdversarialTerrain> {};

TEST_P(SplitSearchTest, FlagsAreClosedAndNeighboursAgree) {
  const Terrain terrain = test::make_terrain(GetParam().columns, GetParam().rows, GetParam().height);
  for (const std::int64_t cells : {8, 32, 64}) {
    for (const double bound : {0.5, 8.0}) expect_sound_windows(terrain, cells, bound);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, SplitSearchTest, testing::ValuesIn(test::everyday_terrains()),
                         [](const auto& shape) { return shape.param.name; });

TEST(SplitSearch, NeighboursAgreeOnRandomTerrain) {
  // Squares of 8, 16 and 32 cells: below, at and above the smallest of the residual pyramid.
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const double holes = seed % 3 == 0 ? 0 : 1e-4 * std::pow(8.0, seed % 3);
    const Terrain terrain = test::make_terrain(1200, 900, test::rough_hills(30, 1, holes, seed));
    expect_sound_windows(terrain, std::int64_t{128} << seed % 3, 0.6 * std::pow(2.0, seed));
  }
}

TEST(SplitSearch, ASplitReachesHalfASquare) {
  constexpr std::int64_t kCells = 256;
  const LevelGrid level = level_of(kCells, 1);
  const std::int64_t square = level.square();
  int beyond_the_square = 0;
  for (int k = 0; k < 40; ++k) {
    // Every kind of point in the square, its sides and corners too.
    const int step = 1 << k % 5;
    const int column = 512 + kCells / 2 + static_cast<int>(test::noise(k, 1) * 16 / step) * step;
    const int row = 512 + kCells / 2 + static_cast<int>(test::noise(k, 2) * 16 / step) * step;
    const Terrain terrain =
        test::make_terrain(1290, 1290, [&](int c, int r) { return c == column && r == row ? 100.0 : 0.0; });
    const Window w(terrain, level, 2, 2);
    for (std::int64_t y = 0; y <= w.span(); ++y) {
      for (std::int64_t x = 0; x <= w.span(); ++x) {
        if (!w.flags.get(x, y) || (x % square == 0 && y % square == 0)) continue;
        // How far off the squares that have the spike in them or on their sides.
        const auto off = [&](std::int64_t at, std::int64_t origin, int spike) {
          const std::int64_t p = spike - origin;
          const std::int64_t low = (p + square - 1) / square * square - square;
          const std::int64_t high = p / square * square + square;
          return std::max<std::int64_t>({low - at, at - high, 0});
        };
        const std::int64_t reach = std::max(off(x, w.column0, column), off(y, w.row0, row));
        EXPECT_LE(reach, square / 2) << "spike " << column << ' ' << row;
        beyond_the_square += reach > 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(beyond_the_square, 0);
}

TEST(SplitSearch, FlatGroundIsNotSplitUpToTheRastersEdge) {
  // The raster ends on, before and behind a line of the residual pyramid.
  for (const int samples : {513, 520, 529, 545}) {
    const Terrain terrain = test::make_terrain(samples, samples, [](int, int) { return 0.0; });
    const LevelGrid level = level_of(512, 1);
    const Window w(terrain, level, 0, 0);
    expect_closed(w);
    const std::int64_t square = level.square();
    std::int64_t flags = 0;
    for (std::int64_t r = 0; r <= 512; ++r) {
      for (std::int64_t c = 0; c <= 512 - square; ++c)
        flags += w.at(c, r) && (c % square != 0 || r % square != 0) ? 1 : 0;
    }
    EXPECT_LT(flags, 512 * 4) << samples;
  }
}

}  // namespace
}  // namespace tintree::simplify
