#pragma once

#include <cstdint>
#include <vector>

#include "simplify/level_grid.h"
#include "simplify/reference_surface.h"
#include "simplify/split_flags.h"

namespace tintree::simplify {

/// How many squares (LevelGrid::square) around a tile take part in its start mesh. What lies further away has no
/// influence on the triangles that touch the tile: a forced split reaches half a square.
inline constexpr std::int64_t kRingSquares = 2;

/// Decides which right triangles to split so that all of them stay within the level's bound, and the edges along
/// the sides of tiles within half of it. The level's start mesh is one right-triangulated irregular network
/// (Evans et al. 2001) over the whole DEM: squares of side LevelGrid::square with alternating diagonals, split at
/// the middle of the longest side. A split may force splits of larger triangles, but never of a square's own
/// corners; so the mesh at a place depends on the samples nearby alone, and neighbouring tiles agree on it.
///
/// Returns the flags of the window from (column0 - ring, row0 - ring), ring = kRingSquares squares, to as far
/// beyond the tile: at each grid point whether the triangles that meet there exist. They are final in the tile, half a
/// square around it and so for all triangles outside it that touch it. Ends early, with some of them, once the view is
/// interrupted. Cost: 10 ns a sample where the surface is rough at this bound, next to nothing where its residual
/// pyramid shows that it is flat.
SplitFlags find_splits(SurfaceView& view, const LevelGrid& level, std::int64_t column0, std::int64_t row0);

/// The same for nested meshes, coarsest first, whose bounds are those of `finest` times 1, 2, 4, ...: what a mesh
/// splits, the finer ones do too. Cost: little more than that of the finest mesh alone.
std::vector<SplitFlags> find_nested_splits(SurfaceView& view, const LevelGrid& finest, int meshes, std::int64_t column0,
                                           std::int64_t row0);

}  // namespace tintree::simplify
