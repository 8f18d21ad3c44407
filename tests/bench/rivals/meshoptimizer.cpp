#include <meshoptimizer.h>

#include "tests/bench/rivals/cpu_clock.h"
#include "tests/bench/rivals/simplifiers.h"

namespace tintree::bench {

Simplified meshoptimizer(const HeightGrid& grid, double error_m) {
  TriangleMesh mesh = full_mesh(grid);
  std::vector<float> positions;
  for (const auto& v : mesh.vertices) {
    for (const double coordinate : v) positions.push_back(static_cast<float>(coordinate));
  }
  std::vector<unsigned> indices;
  for (const auto& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  constexpr std::size_t kStride = 3 * sizeof(float);

  const CpuClock clock;
  const float scale = meshopt_simplifyScale(positions.data(), mesh.vertices.size(), kStride);
  const std::size_t left =
      meshopt_simplify(indices.data(), indices.data(), indices.size(), positions.data(), mesh.vertices.size(), kStride,
                       0, static_cast<float>(error_m) / scale, 0, nullptr);
  const double seconds = clock.seconds();

  mesh.triangles.clear();
  for (std::size_t i = 0; i < left; i += 3) mesh.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
  return {compacted(mesh), seconds};
}

}  // namespace tintree::bench
