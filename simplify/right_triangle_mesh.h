#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "simplify/half_edge_mesh.h"
#include "simplify/height_lattice.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {

/// A tile before its simplification.
struct StartMesh {
  std::vector<LatticeVertex> vertices;  ///< x and y in whole samples.
  std::vector<std::array<std::int32_t, 3>> triangles;
  /// For each sample along the north, south, west and east side: its vertex, or kNone.
  std::array<std::vector<std::int32_t>, 4> sides;
};

/// The four corner cells of a tile, whose diagonal its border ribbons may need flipped.
struct CornerFlips {
  bool north_east = false;
  bool south_west = false;
};

/// Triangulates a tile's square of `cells` x `cells` (a power of two) by right triangles, split until every
/// one stays within `bound_m` of the surface (right-triangulated irregular network; Evans et al. 2001).
/// Corners have snapped heights. The cells along the tile's border are at full resolution with the surface's
/// own diagonals, as the ribbons need them; only flags are stored, so coarse levels of a flat surface stop at
/// once. Covers exactly the surface's domain in the square. Cost: 10 to 50 ns a sample where the surface is
/// rough at this bound, next to nothing where its residual pyramid shows that it is flat. Gives an empty mesh without
/// sides once the view is interrupted.
StartMesh right_triangle_mesh(SurfaceDistance& distance, const SurfaceView& view, std::int64_t column0,
                              std::int64_t row0, std::int64_t cells, double bound_m, const HeightLattice& heights,
                              const CornerFlips& flips);

}  // namespace tintree::simplify
