#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "codec/error.h"
#include "tests/bench/rivals/height_grid.h"

namespace tintree::bench {

/// What every simplifier makes: vertices x = column * dx_m, y = -row * dy_m, z in metres.
struct TriangleMesh {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Counter-clockwise seen from above.
};

/// The reference surface itself, up to two triangles a cell: what mesh simplifiers start from.
TriangleMesh full_mesh(const HeightGrid& grid);

/// Without the vertices that no triangle uses.
TriangleMesh compacted(const TriangleMesh& mesh);

/// The files of tintree-export and of this folder: binary little-endian PLY, doubles, triangles.
Expected<TriangleMesh> read_ply(const std::string& path);
Expected<void> write_ply(const std::string& path, const TriangleMesh& mesh);

}  // namespace tintree::bench
