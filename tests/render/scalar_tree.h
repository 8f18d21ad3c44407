#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "codec/scalar_grid.h"
#include "tests/render/analytic_tree.h"

namespace tintree::test {

/// An analytic tree whose meshes are grids of method scalar: on the sides heights are exact, inside they are quantised,
/// in every tile from another height on.
struct ScalarTree : AnalyticTree {
  bool table = false;  ///< By levels the closer the lower they are, else by even ones.

  static std::int32_t quantized(std::int32_t z, std::int32_t first, bool table) {
    if (!table) return (z - first) / 7 * 7 + first;
    const auto root = static_cast<std::int32_t>(std::sqrt(static_cast<double>(z - first)));
    return root * root + first;
  }

  static std::vector<std::int32_t> places(std::int32_t length) {
    std::vector<std::int32_t> out;
    for (std::int32_t at = 0; at < length; at += 2) out.push_back(at);
    out.push_back(length);
    return out;
  }

  codec::TileMesh mesh(const codec::TileId& id) const {
    const codec::TreeLayout l = layout();
    const codec::CellRect c = l.cells(id);
    codec::ScalarTile tile;
    tile.xy_shift = l.leaf_level - id.level;
    const auto width = static_cast<std::int32_t>((c.column1 - c.column0) >> tile.xy_shift);
    const auto height = static_cast<std::int32_t>((c.row1 - c.row0) >> tile.xy_shift);
    tile.shape.blocks = codec::BlockTree(width, height, 2);
    for (int side = 0; side < 4; ++side)
      tile.shape.sides[static_cast<std::size_t>(side)] = places(tile.shape.length(side));
    tile.shape.blocks.split(tile.shape.blocks.at(width / 2, height / 2).node);
    tile.shape.blocks.split(tile.shape.blocks.at(0, 0).node);
    const auto first = static_cast<std::int32_t>(3 + 2 * id.x + id.y);
    tile.z_offset = -2000 - 13 * std::int64_t{id.x} - 31 * std::int64_t{id.y};
    codec::ScalarGrid grid = *codec::make_scalar_grid(tile.shape);
    for (std::size_t i = 0; i < grid.places.size(); ++i) {
      const std::int64_t column = c.column0 + (std::int64_t{grid.places[i].x} << tile.xy_shift);
      const std::int64_t row = c.row0 + (std::int64_t{grid.places[i].y} << tile.xy_shift);
      const auto z = static_cast<std::int32_t>(steps(column, row) - tile.z_offset);
      tile.z.push_back(i < grid.border_count ? z : quantized(z, first, table));
      const auto metres = [&](std::int64_t samples) { return static_cast<double>(samples) * spacing_m; };
      if (hole) tile.missing.push_back(hole(metres(column), -metres(row)));
    }
    return tile.mesh(std::move(grid));
  }
};

}  // namespace tintree::test
