#pragma once

#include <cstddef>
#include <cstdint>

#include "codec/tile_mesh.h"
#include "tests/render/analytic_tree.h"

namespace tintree::test {

/// An analytic tree whose meshes are restricted quadtrees: diagonals lead to the middles of squares.
struct QuadtreeTree : AnalyticTree {
  codec::TileMesh mesh(const codec::TileId& id) const {
    codec::TileMesh out = AnalyticTree::mesh(id);
    const std::int64_t step = stride(layout(), id.level);
    for (std::size_t i = 0; i + 1 < out.triangles.size(); i += 2) {
      const std::uint32_t nw = out.triangles[i][0];
      const std::uint32_t sw = out.triangles[i][1];
      const std::uint32_t ne = out.triangles[i][2];
      const std::uint32_t se = out.triangles[i + 1][2];
      if ((out.vertices[nw].x / step + out.vertices[nw].y / step) % 2 != 0) continue;
      out.triangles[i] = {nw, sw, se};
      out.triangles[i + 1] = {nw, se, ne};
    }
    return out;
  }
};

}  // namespace tintree::test
