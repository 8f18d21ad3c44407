#include "simplify/right_triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "simplify/split_search.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {
namespace {

/// How often the descent looks whether it has been interrupted.
constexpr std::uint32_t kStepsPerLook = 4096;

/// Every second bit of a Morton code, packed.
std::int64_t every_second_bit(std::int64_t code) {
  std::int64_t out = 0;
  for (int bit = 0; (code >> (2 * bit)) != 0; ++bit) out |= (code >> (2 * bit) & 1) << bit;
  return out;
}

}  // namespace

bool may_flip(SurfaceView& view, const LevelGrid& level, std::int64_t column, std::int64_t row) {
  const double nw = view.sample(column, row);
  const double ne = view.sample(column + 1, row);
  const double sw = view.sample(column, row + 1);
  const double se = view.sample(column + 1, row + 1);
  // A missing sample makes the difference NaN and the answer no; snap() must not see it.
  if (std::isnan(nw + ne + sw + se)) return false;
  const double tested = tested_bound_m(view.surface(), {column, row, column + 1, row + 1}, level.bound_m);
  return std::abs((level.heights.snapped_m(ne) + level.heights.snapped_m(sw)) / 2 - (nw + se) / 2) <= tested;
}

RightTriangleMesh::RightTriangleMesh(SurfaceView& view, const LevelGrid& level, std::int64_t column0, std::int64_t row0)
    : view_(&view),
      level_(level),
      square_(level.square()),
      ring_(kRingSquares * square_),
      column0_(column0 - ring_),
      row0_(row0 - ring_),
      flags_(find_splits(view, level, column0, row0)) {
  vertex_of_rank_.assign(static_cast<std::size_t>(flags_.number()), kNone);
}

void RightTriangleMesh::begin(std::int64_t origin_x, std::int64_t origin_y) {
  origin_ = {origin_x, origin_y};
  met_open_cell_ = false;
}

StartMesh RightTriangleMesh::finish() {
  for (const std::int32_t rank : used_ranks_) vertex_of_rank_[static_cast<std::size_t>(rank)] = kNone;
  used_ranks_.clear();
  return std::exchange(mesh_, {});
}

StartMesh RightTriangleMesh::tile() {
  begin(ring_, ring_);
  in_band_ = false;
  const std::int64_t across = level_.cells / square_;
  for (std::int64_t k = 0; k < across * across; ++k) {
    const std::int64_t x = ring_ + every_second_bit(k) * square_;
    const std::int64_t y = ring_ + every_second_bit(k >> 1) * square_;
    for (const auto& [a, b, c] : halves(x, y)) descend(a, b, c);
  }
  return finish();
}

StartMesh RightTriangleMesh::band(const Side& side, std::array<bool, 2>& open_ends) {
  const GridPoint start{side.column - column0_, side.row - row0_};
  begin(start.x, start.y);
  in_band_ = true;
  southward_ = side.southward;
  line_ = southward_ ? start.x : start.y;
  open_ends = {false, false};
  const std::int64_t squares = side.cells / square_;
  for (std::int64_t k = 0; k < squares; ++k) {
    const bool at_end = k == 0 || k == squares - 1;
    for (const std::int64_t back : {square_, std::int64_t{0}}) {
      const std::int64_t x = southward_ ? start.x - back : start.x + k * square_;
      const std::int64_t y = southward_ ? start.y + k * square_ : start.y - back;
      for (const auto& [a, b, c] : halves(x, y)) {
        // Beyond the diagonal of a square at the end lies the other side's band.
        if (at_end && on_line(a) + on_line(b) + on_line(c) < 2) continue;
        met_open_cell_ = false;
        descend(a, b, c);
        if (met_open_cell_) open_ends[k == 0 ? 0 : 1] = true;
      }
    }
  }
  return finish();
}

/// The two halves of a square, each hypotenuse first, apex last, counter-clockwise from above.
std::array<std::array<RightTriangleMesh::GridPoint, 3>, 2> RightTriangleMesh::halves(std::int64_t x,
                                                                                     std::int64_t y) const {
  const GridPoint nw{x, y};
  const GridPoint ne{x + square_, y};
  const GridPoint sw{x, y + square_};
  const GridPoint se{x + square_, y + square_};
  const bool even = ((x / square_ + y / square_) & 1) == 0;
  if (even) return {{{nw, se, ne}, {se, nw, sw}}};
  return {{{sw, ne, nw}, {ne, sw, se}}};
}

/// Triangle with hypotenuse a-b and apex c, counter-clockwise from above.
void RightTriangleMesh::descend(GridPoint a, GridPoint b, GridPoint c) {
  if (++steps_ % kStepsPerLook == 0) interrupted_ = view_->interrupted();
  if (interrupted_ || !touches(a, b, c)) return;
  if (std::abs(a.x - b.x) == 1 && std::abs(a.y - b.y) == 1) {
    emit_half_cell(a, b, c);
    return;
  }
  const GridPoint middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
  if (!flags_.get(middle.x, middle.y)) {
    emit(a, b, c);
    return;
  }
  descend(c, a, middle);
  descend(b, c, middle);
}

/// What the cells north-east and south-west of a tile's corner, whose diagonals do not meet the corner, become.
RightTriangleMesh::CornerCell RightTriangleMesh::corner_cell(GridPoint cell) {
  const std::int64_t last = level_.cells - 1;
  const std::int64_t x = (cell.x - ring_) & last;
  const std::int64_t y = (cell.y - ring_) & last;
  if (!(x == 0 && y == last) && !(x == last && y == 0)) return CornerCell::kOrdinary;
  return may_flip(*view_, level_, column0_ + cell.x, row0_ + cell.y) ? CornerCell::kFlipped : CornerCell::kOpen;
}

/// Half a unit cell. Where the other half is a triangle too, the two get the surface's own diagonal.
void RightTriangleMesh::emit_half_cell(GridPoint a, GridPoint b, GridPoint c) {
  const GridPoint d{a.x + b.x - c.x, a.y + b.y - c.y};
  const bool whole = flags_.get(c.x, c.y) && flags_.get(d.x, d.y);
  const bool along = (a.x - b.x) == (a.y - b.y);
  if (!whole || along) {
    emit(a, b, c);
    return;
  }
  const CornerCell corner = corner_cell({std::min(a.x, b.x), std::min(a.y, b.y)});
  if (corner == CornerCell::kFlipped) {
    emit(a, b, c);
  } else if (corner == CornerCell::kOpen && in_band_) {
    // Where the cell has no surface nothing is left uncut.
    met_open_cell_ = met_open_cell_ || (exists(c) && exists(d) && (exists(a) || exists(b)));
  } else {
    // The diagonal runs from c to d; of the two halves take the one on a's side.
    emit(c, a, d);
  }
}

void RightTriangleMesh::emit(GridPoint a, GridPoint b, GridPoint c) {
  const auto there = [this](GridPoint p) { return is_vertex(p) || exists(p); };
  if (there(a) && there(b) && there(c)) mesh_.triangles.push_back({vertex(a), vertex(b), vertex(c)});
}

double RightTriangleMesh::height_m(GridPoint p) const { return view_->sample(column0_ + p.x, row0_ + p.y); }

bool RightTriangleMesh::is_vertex(GridPoint p) const {
  return vertex_of_rank_[static_cast<std::size_t>(flags_.rank(p.x, p.y))] != kNone;
}

/// The vertex at a sample that exists, made on first use.
std::int32_t RightTriangleMesh::vertex(GridPoint p) {
  const std::int32_t rank = flags_.rank(p.x, p.y);
  std::int32_t& v = vertex_of_rank_[static_cast<std::size_t>(rank)];
  if (v == kNone) {
    const double h = height_m(p);
    // Heights of a tile and of two that meet at a sample are far fewer than 2^31 steps apart.
    if (mesh_.vertices.empty()) mesh_.heights = {level_.heights.step_m, level_.heights.address(h)};
    v = static_cast<std::int32_t>(mesh_.vertices.size());
    used_ranks_.push_back(rank);
    mesh_.vertices.push_back({static_cast<std::int32_t>(p.x - origin_.x), static_cast<std::int32_t>(p.y - origin_.y),
                              mesh_.heights.snap(h)});
  }
  return v;
}

}  // namespace tintree::simplify
