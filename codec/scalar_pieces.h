#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/scalar_shape.h"

namespace tintree::codec {

/// A vertex's place on its tile's grid, in address steps from its north-west corner.
struct GridPlace {
  std::int32_t x = 0;
  std::int32_t y = 0;

  friend bool operator==(const GridPlace&, const GridPlace&) = default;
};

/// What a tile of method `scalar` is put together from.
class ScalarPieces {
 public:
  virtual ~ScalarPieces() = default;
  /// A rectangle cut from north-west to south-east.
  virtual void cell(const GridPlace& nw, const GridPlace& se) = 0;
  /// Triangles from a vertex inside to each edge of the closed line around it, counter-clockwise from above.
  virtual void fan(const GridPlace& hub, std::span<const GridPlace> around) = 0;
  /// Counter-clockwise from above.
  virtual void triangle(const GridPlace& a, const GridPlace& b, const GridPlace& c) = 0;
};

/// Goes through a tile's pieces, block by block.
///
/// A cell is cut from north-west to south-east if it has vertices at its corners alone. Where it has others, in the
/// middle of an edge that it shares with finer cells and on the tile's sides, it is a fan about its middle, rounded
/// down. Along an edge of a side that is longer than a cell all the cells at it are one such rectangle; one that is a
/// single step wide is joined in the order of the middles of its long sides' edges. A tile's corner cell at which an
/// edge of a side is longer than it is cut by a seam from the tile's corner to the cell's own; what lies on either side
/// of the seam is joined as a rectangle one step wide. (Fowler et al., section 4.3, stitch tiles in this way.)
class ScalarPieceWalk {
 public:
  /// The shape must not change meanwhile.
  explicit ScalarPieceWalk(const ScalarShape& shape);

  /// The pieces of a block that is not empty; one that lies in several is the first one's, westward or northward.
  void visit(const GridBlock& block, ScalarPieces& out);

  /// False when the shape was no partition of the tile: neighbours' strides differ by more than a factor of two, cells
  /// along one edge of a side are not of one size, or a tile one step wide has longer edges.
  bool sound() const { return sound_; }

 private:
  using Places = std::vector<GridPlace>;
  struct Cell {
    std::int32_t x0, y0, x1, y1;
    std::int32_t stride;
  };

  Cell cell_at(std::int32_t x, std::int32_t y) const;
  void visit_cell(const Cell& cell, ScalarPieces& out);
  bool touches(const Cell& cell, int side) const;
  static std::array<std::int32_t, 2> span_along(const Cell& cell, int side);
  std::array<std::int32_t, 2> edge_of_side(int side, std::int32_t at) const;
  bool longer_edge(const Cell& cell, int side) const;
  void add_side(int side, std::int32_t from, std::int32_t to, Places& out);
  void add_edge(const Cell& cell, int side, Places& out);
  void rectangle(const std::array<Places, 4>& edges, ScalarPieces& out);
  void along_side(const Cell& cell, int side, ScalarPieces& out);
  static void join(const Places& first, const Places& second, bool horizontal, ScalarPieces& out);

  const ScalarShape* shape_;
  GridBlock block_;             // the one that is visited
  std::array<bool, 4> seam_{};  // at the corner where a side ends clockwise: of the north side, north-east
  bool sound_ = true;
  std::array<Places, 4> edges_;
  Places around_;
};

}  // namespace tintree::codec
