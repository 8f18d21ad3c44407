#include "apps/audit/coverage.h"

#include <algorithm>
#include <array>
#include <tuple>

#include <fmt/format.h>

namespace tintree::audit {
namespace {

/// The three unit edges that belong to a cell: all start at its north-west sample.
enum Kind : std::uint32_t { kRow = 0, kColumn = 1, kDiagonal = 2 };
constexpr std::array<int, 3> kStepX{1, 0, 1};
constexpr std::array<int, 3> kStepY{0, 1, 1};
constexpr std::uint64_t kKinds = 3;

/// Numbers the unit edges of a window row by row, so that they ascend in scan order.
std::uint64_t edge_number(const codec::CellRect& w, std::int64_t column, std::int64_t row, std::uint32_t kind) {
  const std::int64_t cells = w.column1 - w.column0 + 1;
  return static_cast<std::uint64_t>((row - w.row0) * cells + (column - w.column0)) * kKinds + kind;
}

std::string edge_text(const codec::CellRect& w, std::uint64_t number) {
  const std::int64_t cells = w.column1 - w.column0 + 1;
  const auto cell = static_cast<std::int64_t>(number / kKinds);
  const auto kind = static_cast<std::size_t>(number % kKinds);
  const std::int64_t c = w.column0 + cell % cells;
  const std::int64_t r = w.row0 + cell / cells;
  return fmt::format("between samples ({}, {}) and ({}, {}) of the tile", c, r, c + kStepX[kind], r + kStepY[kind]);
}

/// Kind of the grid line that an open edge lies on, or -1.
int kind_of(const TileSurface& s, const Corner& a, const Corner& b) {
  if (a.y == b.y && a.y % s.units == 0) return kRow;
  if (a.x == b.x && a.x % s.units == 0) return kColumn;
  if (a.x - b.x == a.y - b.y && (a.x - a.y) % s.units == 0) return kDiagonal;
  return -1;
}

}  // namespace

void Coverage::add_runs(const HeightWindow& window, const OpenEdge& e, int units) {
  const codec::CellRect& w = window.cells();
  // Unit edges on a window's far sides belong to the next window, where there is one.
  const std::int64_t last_column = w.column1 - (w.column1 == window.tile_width() ? 0 : 1);
  const std::int64_t last_row = w.row1 - (w.row1 == window.tile_height() ? 0 : 1);
  const int step_x = kStepX[e.kind];
  const int step_y = kStepY[e.kind];
  if (step_x == 0 && (e.column < w.column0 || e.column > last_column)) return;
  if (step_y == 0 && (e.row < w.row0 || e.row > last_row)) return;
  const std::int64_t count = (e.lead + e.length + units - 1) / units;
  std::int64_t first = 0;
  std::int64_t last = count - 1;
  if (step_x != 0) {
    first = std::max(first, w.column0 - e.column);
    last = std::min(last, last_column - e.column);
  }
  if (step_y != 0) {
    first = std::max(first, w.row0 - e.row);
    last = std::min(last, last_row - e.row);
  }
  for (std::int64_t i = first; i <= last; ++i) {
    const std::int64_t from = i == 0 ? e.lead : 0;
    const std::int64_t to = i == count - 1 ? e.lead + e.length - i * units : units;
    runs_.push_back({edge_number(w, e.column + i * step_x, e.row + i * step_y, e.kind), static_cast<std::int32_t>(from),
                     static_cast<std::int32_t>(to), e.forward});
  }
}

void Coverage::list_runs(const TileSurface& s, const HeightWindow& window, std::span<const std::uint32_t> edges) {
  runs_.clear();
  for (const std::uint32_t number : edges) {
    if (!s.edges[number].open) continue;
    const Corner& a = s.corners[s.edges[number].a];
    const Corner& b = s.corners[s.edges[number].b];
    const int kind = kind_of(s, a, b);
    if (kind < 0) continue;
    OpenEdge e;
    e.kind = static_cast<std::uint32_t>(kind);
    e.forward = kind == kColumn ? b.y > a.y : b.x > a.x;
    const Corner& start = e.forward ? a : b;
    const Corner& end = e.forward ? b : a;
    e.column = start.x / s.units;
    e.row = start.y / s.units;
    e.lead = kind == kColumn ? start.y % s.units : start.x % s.units;
    e.length = kind == kColumn ? end.y - start.y : end.x - start.x;
    add_runs(window, e, s.units);
  }
  std::ranges::sort(runs_, {}, [](const Run& r) { return std::tuple(r.edge, r.from, r.to, r.forward); });
}

std::uint64_t Coverage::list_outline(const HeightWindow& window) {
  const codec::CellRect& w = window.cells();
  const bool east_end = w.column1 == window.tile_width();
  const bool south_end = w.row1 == window.tile_height();
  std::uint64_t triangles = 0;
  outline_.clear();
  const auto put = [&](std::int64_t c, std::int64_t r, Kind kind, bool forward) {
    outline_.push_back({edge_number(w, c, r, kind), forward});
  };
  window.triangles_of_row(w.row0 - 1, above_);
  for (std::int64_t r = w.row0; r < w.row1 + (south_end ? 1 : 0); ++r) {
    const bool has_cells = r < w.row1;
    if (has_cells) {
      window.triangles_of_row(r, here_);
    } else {
      here_.assign(above_.size(), 0);
    }
    for (std::int64_t c = w.column0; c < w.column1; ++c) {
      const auto i = static_cast<std::size_t>(c - w.column0 + 1);
      const bool north = (above_[i] & kLower) != 0;
      const bool west = (here_[i - 1] & kUpper) != 0;
      const bool lower = (here_[i] & kLower) != 0;
      const bool upper = (here_[i] & kUpper) != 0;
      triangles += (lower ? 1U : 0U) + (upper ? 1U : 0U);
      // Counter-clockwise seen from above: a triangle's south side is run eastward, its west side southward.
      if (north != upper) put(c, r, kRow, north);
      if (has_cells && west != lower) put(c, r, kColumn, lower);
      if (lower != upper) put(c, r, kDiagonal, upper);
    }
    if (east_end && has_cells && (here_.back() & kUpper) != 0) put(w.column1, r, kColumn, false);
    above_.swap(here_);
  }
  return triangles;
}

Faults Coverage::compare(const HeightWindow& window, int units) const {
  Faults faults;
  const codec::CellRect& w = window.cells();
  auto run = runs_.begin();
  for (const Outline& unit : outline_) {
    for (; run != runs_.end() && run->edge < unit.edge; ++run) {
      faults.add("the mesh is open inside the surface or reaches beyond it, " + edge_text(w, run->edge));
    }
    std::int32_t reached = 0;
    bool whole = true;
    for (; run != runs_.end() && run->edge == unit.edge; ++run) {
      whole = whole && run->from == reached && run->forward == unit.forward;
      reached = run->to;
    }
    if (!whole || reached != units) {
      faults.add("the mesh does not follow the outline of the surface " + edge_text(w, unit.edge));
    }
  }
  for (; run != runs_.end(); ++run) {
    faults.add("the mesh is open inside the surface or reaches beyond it, " + edge_text(w, run->edge));
  }
  return faults;
}

Coverage::Result Coverage::check(const TileSurface& surface, const HeightWindow& window,
                                 std::span<const std::uint32_t> edges) {
  Result result;
  list_runs(surface, window, edges);
  result.reference_triangles = list_outline(window);
  result.faults = compare(window, surface.units);
  return result;
}

Faults place_open_edges(const TileSurface& s) {
  Faults faults;
  for (const Edge& e : s.edges) {
    if (!e.open) continue;
    const Corner& a = s.corners[e.a];
    const Corner& b = s.corners[e.b];
    const bool outside = std::max(a.x, b.x) > s.width_units() || std::max(a.y, b.y) > s.height_units();
    if (kind_of(s, a, b) >= 0 && !outside) continue;
    faults.add(fmt::format(
        "the mesh is open {} the surface, between ({:.10g}, {:.10g}) and ({:.10g}, {:.10g}) of the tile",
        outside ? "beyond" : "inside", static_cast<double>(a.x) / s.units, static_cast<double>(a.y) / s.units,
        static_cast<double>(b.x) / s.units, static_cast<double>(b.y) / s.units));
  }
  return faults;
}

std::int64_t doubled_area(const TileSurface& s) {
  std::int64_t sum = 0;
  for (const codec::Triangle& t : s.triangles) {
    sum += doubled_area(s.corners[t[0]], s.corners[t[1]], s.corners[t[2]]);
  }
  return sum;
}

}  // namespace tintree::audit
