#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "cache/tile_store.h"
#include "codec/error.h"

namespace tintree::bench {

/// DEM cells along a block's side.
inline constexpr int kBlockCells = 16;

/// What lies on each block of the ground, row-major from the north-west: how much of it, where, and how many
/// triangles of one level of a tree. A triangle over several blocks counts in each by its share of the area.
struct GroundBlocks {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  std::vector<double> triangles;
  std::vector<double> cells;        ///< Area that the mesh covers, in DEM cells.
  std::vector<glm::dvec3> centres;  ///< World, metres: middle of what it covers.
};

/// Reads all tiles of a level. A triangle is cut into equal parts of half a block or less, each of which counts
/// where its middle lies.
Expected<GroundBlocks> ground_blocks(const cache::TileStore& store, int level);

}  // namespace tintree::bench
