#include "codec/scalar_pieces.h"

#include <algorithm>
#include <utility>

namespace tintree::codec {
namespace {

constexpr int kNorth = ScalarShape::kNorth;
constexpr int kEast = ScalarShape::kEast;
constexpr int kSouth = ScalarShape::kSouth;
constexpr int kWest = ScalarShape::kWest;

bool horizontal(int side) { return side == kNorth || side == kSouth; }

/// The corner where a side's places begin and where they end, named by the side that ends there clockwise.
int corner_at(int side, bool end) {
  constexpr std::array<std::array<int, 2>, 4> kCorners{
      {{kWest, kNorth}, {kNorth, kEast}, {kSouth, kEast}, {kWest, kSouth}}};
  return kCorners[static_cast<std::size_t>(side)][end ? 1 : 0];
}

}  // namespace

ScalarPieceWalk::ScalarPieceWalk(const ScalarShape& shape) : shape_(&shape) {
  const std::int32_t right = shape.width() - 1;
  const std::int32_t below = shape.height() - 1;
  const std::array<GridPlace, 4> corners{{{right, 0}, {right, below}, {0, below}, {0, 0}}};
  for (int corner = 0; corner < 4; ++corner) {
    const Cell cell = cell_at(corners[static_cast<std::size_t>(corner)].x, corners[static_cast<std::size_t>(corner)].y);
    seam_[static_cast<std::size_t>(corner)] = longer_edge(cell, corner) || longer_edge(cell, (corner + 1) % 4);
  }
}

void ScalarPieceWalk::visit(const GridBlock& block, ScalarPieces& out) {
  const std::int32_t s = block.stride;
  block_ = block;
  for (std::int32_t j = 0; j < kBlockCells; ++j) {
    const std::int64_t y = block.y + std::int64_t{j} * s;
    if (y >= shape_->height()) break;
    for (std::int32_t i = 0; i < kBlockCells; ++i) {
      const std::int64_t x = block.x + std::int64_t{i} * s;
      if (x >= shape_->width()) break;
      const Cell cell{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                      static_cast<std::int32_t>(std::min<std::int64_t>(x + s, shape_->width())),
                      static_cast<std::int32_t>(std::min<std::int64_t>(y + s, shape_->height())), s};
      // Nothing lies between two steps, and inside the block all cells are alike.
      const bool inside = s == 1 || (i > 0 && j > 0 && i + 1 < kBlockCells && j + 1 < kBlockCells);
      if (inside && x > 0 && y > 0 && cell.x1 < shape_->width() && cell.y1 < shape_->height())
        out.cell({cell.x0, cell.y0}, {cell.x1, cell.y1});
      else
        visit_cell(cell, out);
    }
  }
}

ScalarPieceWalk::Cell ScalarPieceWalk::cell_at(std::int32_t x, std::int32_t y) const {
  const GridBlock block = shape_->blocks.at(x, y);
  const std::int32_t x0 = x - (x - block.x) % block.stride;
  const std::int32_t y0 = y - (y - block.y) % block.stride;
  return {x0, y0, std::min(x0 + block.stride, shape_->width()), std::min(y0 + block.stride, shape_->height()),
          block.stride};
}

bool ScalarPieceWalk::touches(const Cell& cell, int side) const {
  switch (side) {
    case kNorth:
      return cell.y0 == 0;
    case kEast:
      return cell.x1 == shape_->width();
    case kSouth:
      return cell.y1 == shape_->height();
    default:
      return cell.x0 == 0;
  }
}

std::array<std::int32_t, 2> ScalarPieceWalk::span_along(const Cell& cell, int side) {
  return horizontal(side) ? std::array{cell.x0, cell.x1} : std::array{cell.y0, cell.y1};
}

/// The edge of a side that begins at a place or holds it.
std::array<std::int32_t, 2> ScalarPieceWalk::edge_of_side(int side, std::int32_t at) const {
  const std::vector<std::int32_t>& places = shape_->sides[static_cast<std::size_t>(side)];
  const auto next = std::ranges::upper_bound(places, at);
  return {*(next - 1), *next};
}

bool ScalarPieceWalk::longer_edge(const Cell& cell, int side) const {
  const auto [from, to] = span_along(cell, side);
  const auto edge = edge_of_side(side, from);
  return edge[0] < from || edge[1] > to;
}

/// The side's vertices between two places that must be among them.
void ScalarPieceWalk::add_side(int side, std::int32_t from, std::int32_t to, Places& out) {
  const std::vector<std::int32_t>& places = shape_->sides[static_cast<std::size_t>(side)];
  const auto first = std::ranges::lower_bound(places, from);
  const auto last = std::ranges::upper_bound(places, to);
  sound_ = sound_ && last - first >= 2 && *first == from && *(last - 1) == to;
  const std::int32_t across = side == kEast ? shape_->width() : side == kSouth ? shape_->height() : 0;
  for (auto at = first; at != last; ++at)
    out.push_back(horizontal(side) ? GridPlace{*at, across} : GridPlace{across, *at});
}

/// Vertices on an edge of a cell, eastward or southward.
void ScalarPieceWalk::add_edge(const Cell& cell, int side, Places& out) {
  const auto [from, to] = span_along(cell, side);
  if (touches(cell, side)) {
    add_side(side, from, to, out);
    return;
  }
  const std::int32_t x = side == kEast ? cell.x1 : side == kWest ? cell.x0 - 1 : cell.x0;
  const std::int32_t y = side == kSouth ? cell.y1 : side == kNorth ? cell.y0 - 1 : cell.y0;
  const std::int32_t across = side == kEast ? cell.x1 : side == kWest ? cell.x0 : side == kSouth ? cell.y1 : cell.y0;
  const auto place = [&](std::int32_t at) { return horizontal(side) ? GridPlace{at, across} : GridPlace{across, at}; };
  const std::int32_t reach = block_.stride * kBlockCells;
  const bool same = x >= block_.x && y >= block_.y && x - block_.x < reach && y - block_.y < reach;
  const GridBlock next = same ? block_ : shape_->blocks.at(x, y);
  out.push_back(place(from));
  // Neighbours that are finer begin where the cell does, and only the first of them has to be looked at.
  if (!next.empty && next.stride < cell.stride && from + cell.stride / 2 < to)
    out.push_back(place(from + cell.stride / 2));
  sound_ = sound_ && (next.empty || (next.stride >= cell.stride / 2 && cell.stride >= next.stride / 2));
  out.push_back(place(to));
}

void ScalarPieceWalk::visit_cell(const Cell& cell, ScalarPieces& out) {
  std::array<bool, 4> at_side{};
  int sides = 0;
  bool seam = false;
  for (int side = 0; side < 4; ++side) {
    at_side[static_cast<std::size_t>(side)] = touches(cell, side);
    sides += at_side[static_cast<std::size_t>(side)] ? 1 : 0;
  }
  for (std::size_t side = 0; side < 4; ++side) seam = seam || (at_side[side] && at_side[(side + 1) % 4] && seam_[side]);
  const bool opposite = (at_side[kNorth] && at_side[kSouth]) || (at_side[kEast] && at_side[kWest]);
  if (sides == 0 || opposite || (sides == 2 && !seam)) {
    for (int side = 0; side < 4; ++side) {
      edges_[static_cast<std::size_t>(side)].clear();
      add_edge(cell, side, edges_[static_cast<std::size_t>(side)]);
    }
    if (sound_) rectangle(edges_, out);
    return;
  }
  for (int side = 0; side < 4; ++side) {
    if (at_side[static_cast<std::size_t>(side)]) along_side(cell, side, out);
  }
}

/// `edges`: by side, eastward or southward, both ends among them.
void ScalarPieceWalk::rectangle(const std::array<Places, 4>& edges, ScalarPieces& out) {
  const GridPlace nw = edges[kNorth].front();
  const GridPlace se = edges[kSouth].back();
  if (edges[kNorth].size() + edges[kEast].size() + edges[kSouth].size() + edges[kWest].size() == 8) {
    out.cell(nw, se);
  } else if (se.x - nw.x == 1) {
    join(edges[kWest], edges[kEast], false, out);
  } else if (se.y - nw.y == 1) {
    join(edges[kNorth], edges[kSouth], true, out);
  } else {
    around_.assign(edges[kWest].begin(), edges[kWest].end() - 1);
    around_.insert(around_.end(), edges[kSouth].begin(), edges[kSouth].end() - 1);
    around_.insert(around_.end(), edges[kEast].rbegin(), edges[kEast].rend() - 1);
    around_.insert(around_.end(), edges[kNorth].rbegin(), edges[kNorth].rend() - 1);
    out.fan({nw.x + (se.x - nw.x) / 2, nw.y + (se.y - nw.y) / 2}, around_);
  }
}

/// What lies along the edge of a side, or the edges, that this cell is the first one at.
void ScalarPieceWalk::along_side(const Cell& cell, int side, ScalarPieces& out) {
  const auto [from, cell_end] = span_along(cell, side);
  const auto edge = edge_of_side(side, from);
  if (edge[0] < from) return;
  const std::int32_t to = std::max(edge[1], cell_end);
  const bool seam_before = from == 0 && seam_[static_cast<std::size_t>(corner_at(side, false))];
  const bool seam_behind = to == shape_->length(side) && seam_[static_cast<std::size_t>(corner_at(side, true))];
  const int before = horizontal(side) ? kWest : kNorth;
  const int behind = horizontal(side) ? kEast : kSouth;
  const int inward = (side + 2) % 4;
  for (Places& places : edges_) places.clear();
  add_side(side, from, to, edges_[static_cast<std::size_t>(side)]);
  if (!seam_before) add_edge(cell, before, edges_[static_cast<std::size_t>(before)]);
  // The line on the far side of the cells, without its first vertex's repetition.
  Places& line = edges_[static_cast<std::size_t>(inward)];
  Cell last = cell;
  for (std::int32_t at = from; at < to && sound_;) {
    last = horizontal(side) ? cell_at(at, cell.y0) : cell_at(cell.x0, at);
    const auto span = span_along(last, side);
    sound_ = last.stride == cell.stride && span[0] == at && span[1] <= to;
    const bool corner = (at == from && seam_before) || (span[1] == to && seam_behind);
    if (!corner) {
      if (!line.empty()) line.pop_back();
      add_edge(last, inward, line);
    }
    at = span[1];
  }
  if (!sound_) return;
  if (!seam_behind) add_edge(last, behind, edges_[static_cast<std::size_t>(behind)]);
  if (!seam_before && !seam_behind) {
    rectangle(edges_, out);
    return;
  }
  const auto corner_of = [&](const Cell& c, bool at_end) {
    const std::int32_t along = span_along(c, side)[at_end ? 0 : 1];
    const auto [low, high] = span_along(c, before);
    const std::int32_t across = side == kNorth || side == kWest ? high : low;
    return horizontal(side) ? GridPlace{along, across} : GridPlace{across, along};
  };
  if (line.empty()) line.push_back(corner_of(seam_before ? cell : last, !seam_before));
  // A vertex in the middle of the edge that ends the cells where there is no seam.
  const Places& gate = edges_[static_cast<std::size_t>(seam_before ? behind : before)];
  if (gate.size() == 3) line.insert(seam_before ? line.end() : line.begin(), gate[1]);
  const bool first = side == kNorth || side == kWest;
  const Places& outer = edges_[static_cast<std::size_t>(side)];
  join(first ? outer : line, first ? line : outer, horizontal(side), out);
}

/// Two lines, the northern or western one first, that run eastward or southward.
void ScalarPieceWalk::join(const Places& first, const Places& second, bool horizontal, ScalarPieces& out) {
  const auto along = [&](const GridPlace& p) { return horizontal ? p.x : p.y; };
  // An edge across the lines, where both begin or end, needs a triangle that goes beyond it.
  const auto opens = [&](const Places& line, const Places& other) {
    return along(line[0]) == along(line[1]) && along(line[0]) == along(other[0]);
  };
  const auto closes = [&](const Places& line, const Places& other) {
    return along(line[line.size() - 2]) == along(line.back()) && along(line.back()) == along(other.back());
  };
  std::size_t a = 0;
  std::size_t b = 0;
  const std::size_t last_a = first.size() - 1;
  const std::size_t last_b = second.size() - 1;
  while (a < last_a || b < last_b) {
    bool move_second = a == last_a;
    if (a < last_a && b < last_b) {
      const std::int64_t middle_a = std::int64_t{along(first[a])} + along(first[a + 1]);
      const std::int64_t middle_b = std::int64_t{along(second[b])} + along(second[b + 1]);
      move_second = middle_b <= middle_a;
      if ((a == 0 && b == 0 && opens(second, first)) || (b + 1 == last_b && closes(first, second))) move_second = false;
      if ((a == 0 && b == 0 && opens(first, second)) || (a + 1 == last_a && closes(second, first))) move_second = true;
    }
    const GridPlace& p = first[a];
    const GridPlace& q = second[b];
    if (move_second) {
      const GridPlace& r = second[++b];
      horizontal ? out.triangle(p, q, r) : out.triangle(p, r, q);
    } else {
      const GridPlace& r = first[++a];
      horizontal ? out.triangle(p, q, r) : out.triangle(p, r, q);
    }
  }
}

}  // namespace tintree::codec
