#pragma once

#include <string>
#include <vector>

#include "cache/tile_store.h"
#include "codec/error.h"
#include "codec/grid_frame.h"
#include "simplify/tree_builder.h"
#include "tests/simplify/support.h"
#include "tests/support/adversarial_terrain.h"

namespace tintree::test {

/// A tree as a build leaves it: written, measured, finished and opened again.
struct WholeTree {
  cache::TileStore store;
  std::vector<simplify::LevelSummary> levels;
};

Expected<WholeTree> build_whole_tree(const Terrain& terrain, const codec::TreeLayout& layout, const std::string& path,
                                     const std::string& effort = "fast", const std::string& method = "tin",
                                     const std::string& quantizer = "");

/// The terrain's samples. Its file goes at once; the open raster keeps it readable.
Terrain open_terrain(const AdversarialTerrain& shape);

/// The least error, of those from `wished_m` upward, that a build accepts: `wished_m`, or else what its refusal
/// advises. Fails the test when the refusal is not about the data, advises nothing, or the advice does not work.
double accepted_error_m(const Terrain& terrain, int tile_cells, double wished_m);

/// Everything that a tree promises, for each tile of each level, by brute force on the stored bytes: what
/// expect_sound_tile() checks; a stored error that is the true one and within the bound; a tile wherever there is
/// surface and nowhere else; an outline along the square where there are no holes; equal borders of neighbours.
void expect_sound_tree(const Terrain& terrain, const WholeTree& tree);

/// Builds a tree at the least error from `wished_error_m` upward that a build accepts, and checks it by brute force.
void expect_sound_build(const Terrain& terrain, int tile_cells, double wished_error_m, const std::string& method,
                        const std::string& effort = "fast");

}  // namespace tintree::test
