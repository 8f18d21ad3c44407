#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/tile_mesh.h"

namespace tintree::codec {

/// The shape of a tile of method `scalar` (Fowler et al., sections 4.2 and 4.3): a regular grid, and a strip of one
/// cell between it and the tile's four sides, whose vertices are places of their own. Lengths in address steps.
///
/// The inner grid's vertices lie at the multiples of `stride` inside the tile, neither on its sides nor beyond. Its
/// cells, and those cells of the strip that have only their four corners, are cut from north-west to south-east, as the
/// DEM's surface is. Elsewhere the strip runs between the line of a side and the grid's outer line in the order of
/// their edges' middles. Without an inner grid, a tile one step wide, all is cut into cells of 1 x 1.
///
/// Vertices are numbered: north side from west to east, east side southward without its first, south side from
/// west to east without its last, west side southward without its ends; then the inner grid row by row.
struct ScalarGrid {
  enum Side { kNorth, kEast, kSouth, kWest };

  std::int32_t width = 1;
  std::int32_t height = 1;
  std::int32_t stride = 1;
  /// Where along each side its vertices lie, rising, from 0 to its length.
  std::array<std::vector<std::int32_t>, 4> sides;

  std::int32_t length(int side) const { return side == kNorth || side == kSouth ? width : height; }
  /// Of the inner grid.
  std::int64_t columns() const { return (width - 1) / stride; }
  std::int64_t rows() const { return (height - 1) / stride; }
  std::size_t inner_count() const { return static_cast<std::size_t>(columns() * rows()); }
  std::size_t border_count() const;
  std::size_t vertex_count() const { return border_count() + inner_count(); }
  /// Without an inner grid, a vertex at every place of the sides is asked for.
  bool is_sound() const {
    return inner_count() > 0 ||
           border_count() == 2 * (static_cast<std::size_t>(width) + static_cast<std::size_t>(height));
  }

  /// The vertices in their order; z is 0.
  std::vector<GridVertex> places() const;
  /// The triangles between the sides and the inner grid; all of them where there is none.
  std::vector<Triangle> strip() const;
  /// strip(), then the inner grid's.
  std::vector<Triangle> triangles() const;
};

/// A grid whose vertices have heights or are missing.
struct ScalarTile {
  ScalarGrid grid;
  int xy_shift = 0;
  std::int64_t z_offset = 0;
  std::vector<std::int32_t> z;  ///< Of each vertex, in height steps above z_offset.
  std::vector<bool> missing;    ///< Empty when none is. Only at a stride of 1.

  bool is_missing(std::size_t i) const { return !missing.empty() && missing[i]; }
  /// The triangles that have their corners, and the vertices that have a triangle; where triangles meet in a vertex
  /// alone, one for each fan of them.
  TileMesh mesh() const;
};

/// More vertices than a tile of this method may have.
inline constexpr std::int64_t kMaxGridVertices = std::int64_t{1} << 24;

/// The tile whose mesh() holds just these triangles, in whatever order; nothing when there is none.
std::optional<ScalarTile> find_scalar_tile(const TileMesh& mesh);

/// Inverse quantisation of a uniform quantiser as one matrix (equation 5 of the paper): takes an inner vertex's
/// (column, row, index, 1) in its grid to the tile's addresses. `step` and `offset` in height steps. Column-major; with
/// GridFrame::matrix() it multiplies to one matrix from the indices to metres.
std::array<double, 16> inverse_quantization(std::int32_t stride, std::int32_t step, std::int32_t offset);

}  // namespace tintree::codec
