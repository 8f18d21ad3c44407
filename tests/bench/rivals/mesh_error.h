#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/rivals/height_grid.h"
#include "tests/bench/rivals/triangle_mesh.h"

namespace tintree::bench {

/// What a mesh's error really is: vertical distances in metres from the reference surface, where it exists.
struct MeshError {
  double samples_max_m = 0;     ///< At the samples, which is all that most simplifiers look at.
  double surface_max_m = 0;     ///< At every point: samples, vertices, and edges where they cross the grid.
  double rms_m = 0;             ///< Over the covered samples.
  std::uint64_t uncovered = 0;  ///< Samples of the surface that lie under no triangle.
  std::uint64_t filled = 0;     ///< Missing samples that lie under a triangle.
  std::uint64_t folded = 0;     ///< Triangles without area seen from above, or turned over.
  std::vector<float> map_m;     ///< For each sample the largest distance at it or around it; NaN for none.
};

/// Measures any triangles, whoever made them, in double precision; shares no code with simplify/ or the
/// audit. Where triangles overlap the worst counts.
MeshError measure(const HeightGrid& grid, const TriangleMesh& mesh);

}  // namespace tintree::bench
