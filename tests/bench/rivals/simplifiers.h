#pragma once

#include "codec/error.h"
#include "tests/bench/rivals/height_grid.h"
#include "tests/bench/rivals/triangle_mesh.h"

/// Other people's simplifiers, one a file, as one would call them to get a terrain within `error_m`.
/// Which error they really have is measured afterwards.
namespace tintree::bench {

struct Simplified {
  TriangleMesh mesh;
  double seconds = 0;  ///< Processor time of the simplification alone.
};

/// meshopt_simplify (Arseny Kapoulkine): quadric error under a target in metres.
Simplified meshoptimizer(const HeightGrid& grid, double error_m);

/// OpenMesh's decimater: ModQuadric orders, ModHausdorff with `error_m` and ModNormalFlipping forbid.
Simplified openmesh(const HeightGrid& grid, double error_m);

/// CGAL's Lindstrom-Turk edge collapse. It takes a number of edges, not an error: goes on as long as the
/// true error at the samples stays within `error_m`. Vertices are rounded to an eighth of a sample and
/// to error_m/16, which is what is measured. GPL: benchmarks only.
Simplified lindstrom_turk(const HeightGrid& grid, double error_m);

}  // namespace tintree::bench
