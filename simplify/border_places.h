#pragma once

#include <cstdint>
#include <vector>

#include "simplify/level_grid.h"
#include "simplify/reference_surface.h"
#include "simplify/right_triangle_mesh.h"

namespace tintree::simplify {

/// Quantised heights of the samples next to a side may be off by this share of the level's bound. A little more than
/// 7 / 8, a quantiser's half step of three and a half height steps.
inline constexpr double kRowShare = 0.9;

/// Places along a side, in samples from its start, of the vertices that tiles of method `scalar` have there: 0, the end
/// (where the raster ends, or the side's), and between them what halving puts there until each piece holds. A pure
/// function of the samples on the side and in the row on either side of it, so both tiles at it get the same.
///
/// A piece holds if its edge, between heights on the level's lattice, keeps half the bound along the side, and if on
/// both sides of it the strip between it and the next row of samples (ScalarPieceWalk's, at stride 1) keeps the bound
/// whatever heights within kRowShare of the bound that row has. So a grid of every sample fits to it. Pieces of one
/// cell always hold; longer ones do not where a sample of the three rows is missing or the next row is itself a side,
/// and span an eighth of the side at most. Ends early, with pieces of one cell, once the view is interrupted.
std::vector<std::int32_t> border_places(SurfaceView& view, const LevelGrid& level, const Side& side);

}  // namespace tintree::simplify
