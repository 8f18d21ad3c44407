#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::codec {

/// A rectangle of DEM cells: columns [column0, column1) and rows [row0, row1). Its samples are those
/// from column0 to column1 and from row0 to row1, both ends included.
struct CellRect {
  std::int64_t column0 = 0;
  std::int64_t row0 = 0;
  std::int64_t column1 = 0;
  std::int64_t row1 = 0;

  bool empty() const { return column0 >= column1 || row0 >= row1; }
};

/// Which way a DEM's columns and rows run in the world: unit vectors (east, north) of a step to the next
/// column and to the next row. Seen from above the row's lies clockwise of the column's, so that triangles
/// that turn counter-clockwise on the grid do so in the world too. The default is north-up.
struct GridAxes {
  std::array<double, 2> column{1, 0};
  std::array<double, 2> row{0, -1};

  /// Metres east and north of the first sample, from metres along the columns' and the rows' way.
  std::array<double, 2> world(double across_m, double down_m) const {
    return {across_m * column[0] + down_m * row[0], across_m * column[1] + down_m * row[1]};
  }
  /// The way back: metres along the columns' and the rows' way.
  std::array<double, 2> grid(double east_m, double north_m) const;

  friend bool operator==(const GridAxes&, const GridAxes&) = default;
};

/// How a quadtree lies over a DEM. Samples are numbered from one corner, the north-west one unless the DEM
/// is rotated. World coordinates are metres east, north and up of that sample (docs/format.md, Coordinates).
struct TreeLayout {
  std::int64_t columns = 0;  ///< Samples of the DEM, 2 or more each way.
  std::int64_t rows = 0;
  int tile_cells = 256;  ///< DEM cells along a leaf's side, a power of two.
  int leaf_level = 0;    ///< Level of the leaves; 0 when one tile holds the whole DEM.
  /// Levels from an error to half of it, 1 or 2. With 2, errors of levels are a factor of √2 apart, and below the root
  /// two levels lie on the same squares: a tile whose square is halved has four children, and each of those one, on
  /// its own square.
  int levels_per_doubling = 1;
  double dx_m = 1;  ///< Sample spacing along a row, from column to column,
  double dy_m = 1;  ///< and from row to row.
  GridAxes axes;
  /// World x and y of the first sample. Not stored: 0, but in a scene of several trees.
  std::array<double, 2> origin_m{0, 0};
  double leaf_error_m = 0;       ///< Error bound of the leaves.
  std::vector<double> z_step_m;  ///< Height step of each level, index 0 the root.

  /// The smallest leaf level whose root covers a DEM of this size.
  static int leaf_level_for(std::int64_t columns, std::int64_t rows, int tile_cells, int levels_per_doubling = 1);

  /// Error bound of a level: leaf_error_m, doubled once in levels_per_doubling levels up.
  double bound_m(int level) const;
  /// How often the root's side is halved for that of the tiles of `level`,
  int halvings(int level) const { return (level + levels_per_doubling - 1) / levels_per_doubling; }
  /// and the coarsest level after so many.
  int coarsest_level(int halvings) const { return halvings == 0 ? 0 : (halvings - 1) * levels_per_doubling + 1; }
  /// Squares that the tiles of `level` have their children on: the 4 quadrants of their own, or that 1.
  int child_count(int level) const { return halvings(level + 1) > halvings(level) ? 4 : 1; }
  /// Whether its tiles are as small as the leaves.
  bool is_leaf_square(int level) const { return halvings(level) == halvings(leaf_level); }
  /// The same squares, and below the leaves' theirs, halved so many times more: fewer than halve a leaf to one cell.
  TreeLayout deepened(int halvings) const;
  /// Undefined for the root.
  TileId parent(const TileId& id) const;
  /// `which` is less than child_count(): of 4, 0 is north-west, 1 north-east, 2 south-west, 3 south-east (Z-order).
  TileId child(const TileId& id, int which) const;
  /// The coarsest tile on the same square, itself or its parent. It has the textures and normal maps of both.
  TileId picture_tile(const TileId& id) const { return {coarsest_level(halvings(id.level)), id.x, id.y}; }
  /// World x and y of a place on the grid, and back.
  std::array<double, 2> world(double column, double row) const {
    const auto [x, y] = axes.world(column * dx_m, row * dy_m);
    return {origin_m[0] + x, origin_m[1] + y};
  }
  std::array<double, 2> grid(double x_m, double y_m) const;
  /// DEM cells along the side of a tile of `level`.
  std::int64_t cells_across(int level) const {
    return std::int64_t{tile_cells} << (halvings(leaf_level) - halvings(level));
  }
  /// Tiles of `level` that hold at least one cell of the raster, along x and along y.
  std::uint32_t tiles_x(int level) const;
  std::uint32_t tiles_y(int level) const;
  /// The tile's cells, cut to the raster.
  CellRect cells(const TileId& id) const;
};

/// Places one tile's grid addresses in the world: local grid address <-> metres as one matrix
/// (Fowler et al.: dequantisation is a matrix product).
struct GridFrame {
  std::int64_t column0 = 0;  ///< DEM sample at the tile's north-west corner.
  std::int64_t row0 = 0;
  int xy_shift = 0;
  std::int64_t z_offset = 0;
  double z_step_m = 1;
  double dx_m = 1;
  double dy_m = 1;
  GridAxes axes;
  std::array<double, 2> origin_m{0, 0};  ///< World x and y of the DEM's first sample.

  GridFrame() = default;
  GridFrame(const TreeLayout& layout, const TileId& id, const TileMesh& mesh);

  /// DEM column and row of an address; exact (a dyadic fraction).
  double column(std::int32_t x) const;
  double row(std::int32_t y) const;
  /// Height in metres. Depends on z_offset + z alone, so two tiles that share a vertex agree on every bit.
  double height_m(std::int32_t z) const { return static_cast<double>(z_offset + z) * z_step_m; }
  /// World position of a vertex, metres.
  std::array<double, 3> world(const GridVertex& v) const;
  /// Column-major 4x4 matrix from (x, y, z, 1) addresses to world metres relative to `eye`; the
  /// subtraction is made in double, so the result is exact enough for float near the eye.
  std::array<double, 16> matrix(const std::array<double, 3>& eye) const;
};

}  // namespace tintree::codec
