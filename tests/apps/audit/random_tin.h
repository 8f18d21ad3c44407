#pragma once

#include <cstdint>

#include "codec/grid_frame.h"
#include "codec/tile_mesh.h"
#include "tests/support/test_raster.h"

namespace tintree::test {

/// A valid irregular mesh over a tile without holes, for measuring: the full-resolution mesh with vertices
/// removed at random where that leaves only proper triangles, and heights moved by up to `noise_m`. With
/// `fine_shift` below 0 inner vertices also leave the samples by fractions of them.
codec::TileMesh random_tin(const HeightGrid& grid, const codec::TreeLayout& layout, const codec::TileId& id,
                           int fine_shift, double noise_m, std::uint64_t seed);

}  // namespace tintree::test
