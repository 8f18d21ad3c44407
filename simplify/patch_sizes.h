#pragma once

namespace tintree::simplify {

/// Triangles and edges longer than this are settled square by square from the residual pyramid.
inline constexpr double kLargeCells = 24;

/// Index into kPatchCells of the squares to begin with over something this long.
constexpr int patch_size_for(double extent) { return extent < 128 ? 0 : extent < 512 ? 1 : 2; }

}  // namespace tintree::simplify
