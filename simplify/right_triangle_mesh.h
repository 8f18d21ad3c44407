#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "simplify/half_edge_mesh.h"
#include "simplify/level_grid.h"
#include "simplify/reference_surface.h"
#include "simplify/split_flags.h"

namespace tintree::simplify {

/// One side that two tiles share: `cells` DEM cells from sample (column, row) eastward or southward.
struct Side {
  std::int64_t column = 0;
  std::int64_t row = 0;
  std::int64_t cells = 0;
  bool southward = false;

  /// Place along the side of a vertex that lies on it, its coordinates relative to the side's start.
  std::int32_t along(const LatticeVertex& v) const { return southward ? v.y : v.x; }
  /// Distance from the side; positive is east or south of it.
  std::int32_t across(const LatticeVertex& v) const { return southward ? v.x : v.y; }
};

/// Triangles over samples at snapped heights, counter-clockwise seen from above.
struct StartMesh {
  std::vector<LatticeVertex> vertices;  ///< x and y in whole samples.
  HeightLattice heights;                ///< What z counts: the level's, from the first vertex.
  std::vector<std::array<std::int32_t, 3>> triangles;
};

/// Whether the cell with its north-west sample at (column, row) may have its diagonal flipped from the
/// surface's own to the other one, at snapped heights: it has all its samples, and the flip stays within the
/// level's bound.
bool may_flip(SurfaceView& view, const LevelGrid& level, std::int64_t column, std::int64_t row);

/// A level's start mesh in and around one tile: right triangles, split by find_splits() until every one stays
/// within the bound. Where both halves of a unit cell are triangles they get the surface's own diagonal, except
/// in the cells at a tile's corner, which are cut towards the corner where may_flip() allows it. Covers exactly
/// the surface's domain. The same wherever two tiles' windows overlap.
class RightTriangleMesh {
 public:
  RightTriangleMesh(SurfaceView& view, const LevelGrid& level, std::int64_t column0, std::int64_t row0);

  /// The tile's part, relative to its north-west sample, along a space-filling curve. Like band() it ends early, with
  /// a part of the triangles, once the view is interrupted.
  StartMesh tile();

  /// The triangles on both sides of one of the tile's sides that touch it, relative to the side's start, cut at
  /// 45 degrees towards its two ends; in an order that depends on the side alone. `open_ends` tells for its
  /// start and its end whether the cut is missing there, because the corner cell cannot be flipped.
  StartMesh band(const Side& side, std::array<bool, 2>& open_ends);

 private:
  struct GridPoint {
    std::int64_t x;
    std::int64_t y;
  };
  enum class CornerCell { kOrdinary, kFlipped, kOpen };

  void begin(std::int64_t origin_x, std::int64_t origin_y);
  StartMesh finish();
  void descend(GridPoint a, GridPoint b, GridPoint c);
  void emit_half_cell(GridPoint a, GridPoint b, GridPoint c);
  void emit(GridPoint a, GridPoint b, GridPoint c);
  std::array<std::array<GridPoint, 3>, 2> halves(std::int64_t x, std::int64_t y) const;
  bool touches(GridPoint a, GridPoint b, GridPoint c) const { return on_line(a) || on_line(b) || on_line(c); }
  bool on_line(GridPoint p) const { return !in_band_ || (southward_ ? p.x : p.y) == line_; }
  CornerCell corner_cell(GridPoint cell);
  double height_m(GridPoint p) const;
  bool exists(GridPoint p) const { return !std::isnan(height_m(p)); }
  bool is_vertex(GridPoint p) const;
  std::int32_t vertex(GridPoint p);

  SurfaceView* view_;
  LevelGrid level_;
  std::int64_t square_;
  std::int64_t ring_;
  std::int64_t column0_;  // of the window
  std::int64_t row0_;
  SplitFlags flags_;

  // The mesh that is being collected.
  StartMesh mesh_;
  std::vector<std::int32_t> vertex_of_rank_;
  std::vector<std::int32_t> used_ranks_;
  GridPoint origin_{};
  bool in_band_ = false;
  bool southward_ = false;
  std::int64_t line_ = 0;
  bool met_open_cell_ = false;
  std::uint32_t steps_ = 0;
  bool interrupted_ = false;
};

}  // namespace tintree::simplify
