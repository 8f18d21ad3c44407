#include "simplify/border_places.h"

#include <algorithm>
#include <cmath>

#include "simplify/spoke_distance.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {
namespace {

/// Pieces in a side at least.
constexpr std::int64_t kPieces = 8;

class SidePieces {
 public:
  SidePieces(SurfaceView& view, const LevelGrid& level, const Side& side)
      : window_(view, side.column, side.row), level_(level), southward_(side.southward) {
    const cache::HeightBlocks& blocks = view.surface().blocks();
    const std::int64_t last_along = (southward_ ? blocks.rows() : blocks.columns()) - 1;
    const std::int64_t last_across = (southward_ ? blocks.columns() : blocks.rows()) - 1;
    const std::int64_t line = southward_ ? side.column : side.row;
    length_ = std::min(side.cells, last_along - (southward_ ? side.row : side.column));
    for (const int d : {-1, 1}) {
      const std::int64_t next = line + d;
      if (next < 0 || next > last_across) continue;
      rows_.push_back(d);
      next_is_side_ = next_is_side_ || next == 0 || next == last_across || next % level.cells == 0;
    }
    codec::CellRect near{side.column, side.row, side.column, side.row};
    (southward_ ? near.row1 : near.column1) += length_;
    // Cells on both sides of the line; tested_bound_m() looks at one more all round.
    (southward_ ? near.column1 : near.row1) = std::min(line + 1, last_across);
    bound_m_ = tested_bound_m(view.surface(), near, level.bound_m);
    line_bound_m_ = tested_bound_m(view.surface(), near, level.bound_m / 2);
  }

  std::vector<std::int32_t> places() {
    places_.assign(1, 0);
    const std::int64_t piece = std::max<std::int64_t>(1, level_.cells / kPieces);
    for (std::int64_t at = 0; at < length_; at += piece) halve(at, piece);
    return places_;
  }

 private:
  void halve(std::int64_t from, std::int64_t piece) {
    if (from >= length_) return;
    const std::int64_t to = std::min(from + piece, length_);
    if (to - from > 1 && !holds(from, to)) {
      halve(from, piece / 2);
      halve(from + piece / 2, piece / 2);
    } else {
      places_.push_back(static_cast<std::int32_t>(to));
    }
  }

  bool holds(std::int64_t from, std::int64_t to) {
    if (next_is_side_ || window_.interrupted()) return false;
    const double start = snapped(from);
    const double slope = (snapped(to) - start) / static_cast<double>(to - from);
    for (std::int64_t at = from; at <= to; ++at) {
      // NaN, of a missing sample, does not hold.
      const double gap = start + slope * static_cast<double>(at - from) - sample(at, 0);
      if (!(std::abs(gap) <= line_bound_m_)) return false;
    }
    return std::ranges::all_of(rows_, [&](int row) { return strip_holds(from, to, row); });
  }

  /// The edges across the strip towards the next row: of its vertices those up to the middle go with the piece's start.
  bool strip_holds(std::int64_t from, std::int64_t to, int row) {
    for (std::int64_t at = from; at <= to; ++at) {
      if (std::isnan(sample(at, row))) return false;
    }
    for (std::int64_t at = from; at <= to; ++at) {
      if (at <= (from + to + 1) / 2 && !edge_holds(from, at, row)) return false;
      if (at >= (from + to) / 2 && !edge_holds(to, at, row)) return false;
    }
    return true;
  }

  bool edge_holds(std::int64_t on_side, std::int64_t at, int row) {
    const double reach = kRowShare * level_.bound_m;
    HeightInterval interval{-reach, reach};
    clip_spoke(window_, point(at, row, sample(at, row)), point(on_side, 0, snapped(on_side)), bound_m_, interval);
    return interval.lo <= -reach && interval.hi >= reach;
  }

  Point point(std::int64_t along, std::int64_t across, double z) const {
    const auto u = static_cast<double>(along);
    const auto v = static_cast<double>(across);
    return southward_ ? Point{v, u, z} : Point{u, v, z};
  }
  double sample(std::int64_t along, std::int64_t across) const {
    return southward_ ? window_.sample(across, along) : window_.sample(along, across);
  }
  double snapped(std::int64_t along) const {
    const double h = sample(along, 0);
    return std::isnan(h) ? h : level_.heights.snapped_m(h);
  }

  SurfaceWindow window_;
  LevelGrid level_;
  bool southward_;
  std::int64_t length_ = 0;
  std::vector<int> rows_;  // next to the side that the raster has: -1, 1
  bool next_is_side_ = false;
  double bound_m_ = 0;  // guard taken off
  double line_bound_m_ = 0;
  std::vector<std::int32_t> places_;
};

}  // namespace

std::vector<std::int32_t> border_places(SurfaceView& view, const LevelGrid& level, const Side& side) {
  return SidePieces(view, level, side).places();
}

}  // namespace tintree::simplify
