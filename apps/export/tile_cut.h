#pragma once

#include <vector>

#include "cache/tile_store.h"
#include "codec/error.h"

namespace tintree::exporter {

/// All tiles of one level, along the Z-order curve. kUsage, naming the range, when there is no such level.
Expected<std::vector<codec::TileId>> tiles_of_level(const cache::TileStore& store, int level);

/// The coarsest tiles that cover the DEM and whose measured error is within `error_m`, along the Z-order
/// curve: a cut through the tree, of several levels where the terrain differs. kUsage, naming the least
/// error that can be had, when there is none. Reads the tiles above the cut.
Expected<std::vector<codec::TileId>> tiles_within(const cache::TileStore& store, double error_m);

}  // namespace tintree::exporter
