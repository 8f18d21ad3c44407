#pragma once

#include <algorithm>
#include <cstdint>

#include "simplify/height_lattice.h"

namespace tintree::simplify {

/// What the start mesh of a level depends on besides the DEM.
struct LevelGrid {
  std::int64_t cells = 0;  ///< DEM cells along a tile's side: a power of two, at least 8.
  double bound_m = 0;      ///< The level's bound, no guard taken off.
  HeightLattice heights;

  /// Side, in cells, of the squares that every tile is divided into at least. Tile corners lie at even squares.
  std::int64_t square() const { return std::max<std::int64_t>(1, cells / 16); }
};

}  // namespace tintree::simplify
