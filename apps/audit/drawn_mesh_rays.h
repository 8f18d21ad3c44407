#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "cache/tile_store.h"
#include "codec/tile_mesh.h"
#include "render/lod_cut.h"

namespace tintree::audit {

/// The meshes of the tiles in a cut as they are stored, without skirts, to be asked in double precision what a driver
/// should have drawn at a pixel. Every question looks at every triangle: about 20 ns each. Memory: 24 bytes a vertex
/// and 12 a triangle. Immutable once read.
class DrawnMeshRays {
 public:
  /// Fails with the error of a tile that cannot be read.
  static Expected<DrawnMeshRays> read(const cache::TileStore& store, const render::LodCut& cut, const glm::dvec3& eye);

  /// The least t > 0 at which eye + t `ray` is on a mesh, or infinity. Rays through an edge hit one of its triangles.
  double cast(const glm::dvec3& ray) const;
  /// From a point of the world to the nearest point of any mesh, metres; infinite without any.
  double distance_m(const glm::dvec3& point) const;

 private:
  glm::dvec3 eye_{};
  std::vector<glm::dvec3> vertices_;  ///< Relative to the eye, metres.
  std::vector<codec::Triangle> triangles_;
};

}  // namespace tintree::audit
