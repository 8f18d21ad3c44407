#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/scalar_shape.h"
#include "codec/tile_mesh.h"

namespace tintree::codec {

/// The triangulation of a tile of method `scalar` (Fowler et al., sections 4.2 and 4.3): regular grids at strides of
/// their own, and what stitches them to each other and to the tile's sides (ScalarPieceWalk).
///
/// Vertices are numbered: north side from west to east, east side southward without its first, south side from
/// west to east without its last, west side southward without its ends; then those inside as triangles come to them:
/// a rectangle's from corner north-west to south-east, north-east and south-west, a fan's hub before the others.
struct ScalarGrid {
  std::vector<GridVertex> places;  ///< In the vertices' order; z is 0.
  std::vector<Triangle> triangles;
  std::size_t border_count = 0;
};

/// Cells of blocks that are not empty; inside the tile there are about as many vertices.
std::int64_t cell_count(const ScalarShape& shape);

/// Nothing when the shape is not sound (ScalarPieceWalk::sound()) or takes more than kMaxGridVertices. Cost: about 0.2
/// microseconds and 70 bytes a vertex.
std::optional<ScalarGrid> make_scalar_grid(const ScalarShape& shape);

/// A grid whose vertices have heights or are missing.
struct ScalarTile {
  ScalarShape shape;
  int xy_shift = 0;
  std::int64_t z_offset = 0;
  std::vector<std::int32_t> z;  ///< Of each vertex, in height steps above z_offset.
  std::vector<bool> missing;    ///< Empty when none is.

  bool is_missing(std::size_t i) const { return !missing.empty() && missing[i]; }
  /// The triangles of the shape's grid that have their corners, and the vertices that have a triangle; where triangles
  /// meet in a vertex alone, one for each fan of them. The mesh has the shape with it.
  TileMesh mesh(ScalarGrid grid) const;
};

/// More vertices than a tile of this method may have.
inline constexpr std::int64_t kMaxGridVertices = std::int64_t{1} << 24;

/// The tile and grid that a mesh of ScalarTile::mesh() was made of; nothing for any other mesh.
struct FoundScalarTile {
  ScalarTile tile;
  ScalarGrid grid;
};
std::optional<FoundScalarTile> find_scalar_tile(const TileMesh& mesh);

/// Inverse quantisation of a uniform quantiser as one matrix (equation 5 of the paper): takes the (column, row, index,
/// 1) of a vertex of a block's grid to the tile's addresses. `step` and `offset` in height steps. Column-major; with
/// GridFrame::matrix() it multiplies to one matrix from the indices to metres.
std::array<double, 16> inverse_quantization(const GridBlock& block, std::int32_t step, std::int32_t offset);

}  // namespace tintree::codec
