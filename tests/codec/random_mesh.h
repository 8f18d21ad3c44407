#pragma once

#include <array>
#include <random>
#include <vector>

#include "codec/tile_mesh.h"

namespace tintree::test {

/// What a made-up mesh should look like.
struct MeshSpec {
  int columns = 8;         ///< Grid cells eastward; each is two triangles.
  int rows = 8;            ///< Grid cells southward.
  double drop = 0;         ///< Chance of a triangle to be left out: holes, islands and pinched vertices.
  double split = 0;        ///< Chance of a corner to get a vertex of its own at the same address.
  int height_range = 100;  ///< Heights are 0 to this.
  std::int64_t z_offset = 0;
  int xy_shift = 0;
};

/// A valid mesh, its vertices and triangles in random order and its triangles turned at random.
codec::TileMesh random_mesh(std::mt19937& random, const MeshSpec& spec);

/// The triangles as addresses, each turned to begin with its least corner, in ascending order: equal for
/// two meshes exactly when they hold the same triangles.
std::vector<std::array<std::array<std::int64_t, 3>, 3>> triangle_set(const codec::TileMesh& mesh);

}  // namespace tintree::test
