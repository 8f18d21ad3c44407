#include "simplify/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simplify/sample_spans.h"
#include "simplify/triangle_plane.h"

namespace tintree::simplify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Smaller triangles (in cells) have no sample off the outer edge whose weight is that low.
constexpr double kAreaOfLightSamples = 1e5;
/// Triangles and spokes longer than this are settled square by square.
constexpr std::int64_t kLarge = 24;

/// Index into kPatchCells of the squares to begin with over something this long.
int patch_size_for(std::int64_t extent) { return extent < 128 ? 0 : extent < 512 ? 1 : 2; }

}  // namespace

double guard_m(double range_m, double bound_m) { return range_m * 0x1p-22 + bound_m * 1e-6; }

double tested_bound_m(const ReferenceSurface& surface, const codec::CellRect& cells, double bound_m) {
  const cache::HeightBlocks& blocks = surface.blocks();
  const auto range = surface.height_range_m(
      {std::max<std::int64_t>(cells.column0 - 1, 0), std::max<std::int64_t>(cells.row0 - 1, 0),
       std::min(cells.column1 + 1, blocks.columns() - 1), std::min(cells.row1 + 1, blocks.rows() - 1)});
  return bound_m - guard_m(std::max(range[1] - range[0], 0.0), bound_m);
}

/// Consecutive samples of one row: pointer to the first, how many the block holds from there on, and the
/// block's base height.
struct SurfaceDistance::SampleRun {
  const float* heights;
  std::int64_t room;
  double base;
};

/// The samples from (x, y) eastward. The sample south of one is kBlockStride further on, unless the row is
/// the raster's last.
SurfaceDistance::SampleRun SurfaceDistance::run_at(std::int64_t x, std::int64_t y) {
  const cache::HeightBlocks& blocks = view_->surface().blocks();
  const std::int64_t column = column0_ + x;
  const std::int64_t row = row0_ + y;
  // The last column and row belong to the block before them.
  const std::int64_t cell_x = std::min(column, blocks.columns() - 2);
  const std::int64_t cell_y = std::min(row, blocks.rows() - 2);
  const cache::HeightBlock& block = view_->block_of(cell_x, cell_y);
  const std::int64_t i = column - (cell_x & ~std::int64_t{255});
  const std::int64_t j = row - (cell_y & ~std::int64_t{255});
  return {block.row(static_cast<int>(j)) + i, cache::kBlockSamples - i, block.base_m};
}

/// The samples of a rectangle that lies in one block; origin is null when it does not.
struct SurfaceDistance::Window {
  const float* origin;
  std::int64_t x0;
  std::int64_t y0;
  double base;

  const float* at(std::int64_t x, std::int64_t y) const { return origin + (y - y0) * cache::kBlockStride + (x - x0); }
};

SurfaceDistance::Window SurfaceDistance::window_over(double x0, double y0, double x1, double y1) {
  const cache::HeightBlocks& blocks = view_->surface().blocks();
  const auto west = static_cast<std::int64_t>(std::floor(x0));
  const auto north = static_cast<std::int64_t>(std::floor(y0));
  const std::int64_t cell_x = std::min(column0_ + west, blocks.columns() - 2);
  const std::int64_t cell_y = std::min(row0_ + north, blocks.rows() - 2);
  const std::int64_t i0 = cell_x & ~std::int64_t{255};
  const std::int64_t j0 = cell_y & ~std::int64_t{255};
  const bool one = static_cast<double>(column0_) + x1 <= static_cast<double>(i0 + cache::kBlockCells) &&
                   static_cast<double>(row0_) + y1 <= static_cast<double>(j0 + cache::kBlockCells);
  if (!one) return {nullptr, 0, 0, 0};
  const cache::HeightBlock& block = view_->block_of(cell_x, cell_y);
  return {block.row(0), i0 - column0_, j0 - row0_, block.base_m};
}

double SurfaceDistance::height_at(double x, double y) {
  const auto i = static_cast<std::int64_t>(std::floor(x));
  const auto j = static_cast<std::int64_t>(std::floor(y));
  const double fx = x - static_cast<double>(i);
  const double fy = y - static_cast<double>(j);
  // Points on a grid line use the samples of that line alone: beyond it the surface may end.
  const double corner = sample(i, j);
  if (fx == 0 && fy == 0) return corner;
  if (fy == 0) return corner + fx * (sample(i + 1, j) - corner);
  if (fx == 0) return corner + fy * (sample(i, j + 1) - corner);
  const double opposite = sample(i + 1, j + 1);
  if (fx == fy) return corner + fx * (opposite - corner);
  if (fx > fy) {
    const double east = sample(i + 1, j);
    return corner + fx * (east - corner) + fy * (opposite - east);
  }
  const double south = sample(i, j + 1);
  return corner + fy * (south - corner) + fx * (opposite - south);
}

namespace {

/// True when the patch alone shows that nothing in its square narrows the interval: with the hub at either
/// end of it, the triangle's plane stays within the bound of all heights that the patch allows.
bool patch_settles(const PlanePatch& patch, double x0, double y0, int cells, const TrianglePlane& plane, double bound_m,
                   const HeightInterval& interval) {
  double lowest = kInfinity;
  double highest = -kInfinity;
  for (int k = 0; k < 4; ++k) {
    const double dx = (k & 1) != 0 ? cells : 0;
    const double dy = (k & 2) != 0 ? cells : 0;
    const double weight = plane.weight(x0 + dx, y0 + dy);
    const double gap =
        plane.height(x0 + dx, y0 + dy) -
        (static_cast<double>(patch.c) + static_cast<double>(patch.a) * dx + static_cast<double>(patch.b) * dy);
    lowest = std::min({lowest, gap + weight * interval.lo, gap + weight * interval.hi});
    highest = std::max({highest, gap + weight * interval.lo, gap + weight * interval.hi});
  }
  return lowest - static_cast<double>(patch.high) >= -bound_m && highest - static_cast<double>(patch.low) <= bound_m;
}

/// What to do with a square of the residual pyramid.
enum class Verdict { kSkip, kOpen, kStop };

}  // namespace

/// Visits one square: `settle(patch, x0, y0, cells)` says whether to skip it, open it or stop the walk; an
/// opened square of the finest size goes to `rows(x0, y0, x1, y1)`, which returns false to stop. False
/// when the walk was stopped.
template <typename Settle, typename Rows>
bool SurfaceDistance::walk_square(int size, std::int64_t x0, std::int64_t y0, const TrianglePlane& plane,
                                  const Settle& settle, const Rows& rows) {
  const int cells = kPatchCells[static_cast<std::size_t>(size)];
  const auto x = static_cast<double>(x0);
  const auto y = static_cast<double>(y0);
  if (plane.misses(x, y, x + cells, y + cells)) return true;
  const std::int64_t column = column0_ + x0;
  const std::int64_t row = row0_ + y0;
  const cache::HeightBlocks& blocks = view_->surface().blocks();
  if (column < 0 || row < 0 || column >= blocks.columns() - 1 || row >= blocks.rows() - 1) return true;
  const PlanePatch& patch = view_->surface()
                                .patches(column >> 8, row >> 8)
                                .at(size, static_cast<int>(column & 255), static_cast<int>(row & 255));
  const Verdict verdict = settle(patch, x, y, cells);
  if (verdict != Verdict::kOpen) return verdict == Verdict::kSkip;
  if (size == 0) return rows(x0, std::max(y0, plane.first_row()), x0 + cells, std::min(y0 + cells, plane.last_row()));
  const int part = kPatchCells[static_cast<std::size_t>(size) - 1];
  for (int j = 0; j < cells; j += part) {
    for (int i = 0; i < cells; i += part) {
      if (!walk_square(size - 1, x0 + i, y0 + j, plane, settle, rows)) return false;
    }
  }
  return true;
}

/// Visits what a triangle covers: a small one goes to `rows` at once, a large one square by square.
template <typename Settle, typename Rows>
bool SurfaceDistance::walk(const TrianglePlane& plane, const Settle& settle, const Rows& rows) {
  const auto x0 = static_cast<std::int64_t>(std::ceil(plane.min_x() - kOnGridLine));
  const std::int64_t y0 = plane.first_row();
  const auto x1 = static_cast<std::int64_t>(std::floor(plane.max_x() + kOnGridLine));
  const std::int64_t y1 = plane.last_row();
  const std::int64_t extent = std::max(x1 - x0, y1 - y0);
  if (extent < kLarge) return rows(x0, y0, x1, y1);
  const int size = patch_size_for(extent);
  const std::int64_t cells = kPatchCells[static_cast<std::size_t>(size)];
  const auto snap_down = [cells](std::int64_t v, std::int64_t origin) {
    return ((v + origin) & ~(cells - 1)) - origin;
  };
  for (std::int64_t y = snap_down(y0, row0_); y <= y1; y += cells) {
    for (std::int64_t x = snap_down(x0, column0_); x <= x1; x += cells) {
      if (!walk_square(size, x, y, plane, settle, rows)) return false;
    }
  }
  return true;
}

void SurfaceDistance::clip_rows(const TrianglePlane& plane, std::int64_t x0, std::int64_t y0, std::int64_t x1,
                                std::int64_t y1, double bound_m, HeightInterval& interval) {
  constexpr int kBatch = 32;
  std::array<RowSpan, kBatch> spans;
  const RowSteps steps{static_cast<float>(plane.wx), static_cast<float>(plane.zx), static_cast<float>(bound_m),
                       plane.area > kAreaOfLightSamples};
  auto lo = static_cast<float>(interval.lo);
  auto hi = static_cast<float>(interval.hi);
  int count = 0;
  const auto flush = [&] {
    clip_spans(spans.data(), count, steps, lo, hi);
    count = 0;
  };
  const auto add = [&](const float* heights, double base, std::int64_t first, std::int64_t y, std::int64_t n) {
    const auto xd = static_cast<double>(first);
    const auto yd = static_cast<double>(y);
    spans[static_cast<std::size_t>(count++)] = {heights, static_cast<int>(n), static_cast<float>(plane.weight(xd, yd)),
                                                static_cast<float>(plane.height(xd, yd) - base)};
    if (count == kBatch) flush();
  };
  const Window window =
      window_over(static_cast<double>(x0), static_cast<double>(y0), static_cast<double>(x1), static_cast<double>(y1));
  for (std::int64_t y = y0; y <= y1 && lo <= hi; ++y) {
    std::int64_t first = std::max(x0, plane.first_in(static_cast<double>(y)));
    const std::int64_t last = std::min(x1, plane.last_in(static_cast<double>(y)));
    if (window.origin != nullptr) {
      if (first <= last) add(window.at(first, y), window.base, first, y, last - first + 1);
      continue;
    }
    for (; first <= last; ++first) {
      const SampleRun run = run_at(first, y);
      const std::int64_t n = std::min(last - first + 1, run.room);
      add(run.heights, run.base, first, y, n);
      first += n - 1;
      // The pinned block may go when another is fetched.
      if (n == run.room && count > 0) flush();
    }
    if ((row0_ + y + 1) % cache::kBlockCells == 0 && count > 0) flush();
  }
  if (count > 0) flush();
  interval.lo = std::max(interval.lo, static_cast<double>(lo));
  interval.hi = std::min(interval.hi, static_cast<double>(hi));
}

bool SurfaceDistance::rows_within(const TrianglePlane& plane, std::int64_t x0, std::int64_t y0, std::int64_t x1,
                                  std::int64_t y1, double bound_m) {
  const RowSteps steps{0, static_cast<float>(plane.zx), static_cast<float>(bound_m)};
  const std::int64_t columns = view_->surface().blocks().columns();
  const std::int64_t rows = view_->surface().blocks().rows();
  for (std::int64_t y = y0; y <= y1; ++y) {
    const auto yd = static_cast<double>(y);
    std::int64_t first = std::max(x0, plane.first_in(yd));
    const std::int64_t last = std::min(x1, plane.last_in(yd));
    if (first <= last && (column0_ + last >= columns || row0_ + y >= rows)) return false;
    while (first <= last) {
      const SampleRun run = run_at(first, y);
      const std::int64_t n = std::min(last - first + 1, run.room);
      const auto at = static_cast<float>(plane.height(static_cast<double>(first), yd) - run.base);
      if (!span_within({run.heights, static_cast<int>(n), 0, at}, steps)) return false;
      first += n;
    }
  }
  return true;
}

bool SurfaceDistance::any_sample(const TrianglePlane& plane) {
  const auto settle = [](const PlanePatch& patch, double, double, int) {
    return patch.empty() ? Verdict::kSkip : Verdict::kOpen;
  };
  return !walk(plane, settle, [&](std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) {
    for (std::int64_t y = y0; y <= y1; ++y) {
      const std::int64_t last = std::min(x1, plane.last_in(static_cast<double>(y)));
      for (std::int64_t x = std::max(x0, plane.first_in(static_cast<double>(y))); x <= last; ++x) {
        if (!std::isnan(sample(x, y))) return false;
      }
    }
    return true;
  });
}

void SurfaceDistance::clip_triangle(const Point& hub, const Point& b, const Point& c, double bound_m,
                                    HeightInterval& interval) {
  const TrianglePlane plane(hub, b, c);
  const auto settle = [&](const PlanePatch& patch, double x0, double y0, int cells) {
    return patch.empty() || patch_settles(patch, x0, y0, cells, plane, bound_m, interval) ? Verdict::kSkip
                                                                                          : Verdict::kOpen;
  };
  walk(plane, settle, [&](std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) {
    clip_rows(plane, x0, y0, x1, y1, bound_m, interval);
    return !interval.empty();
  });
}

SurfaceDistance::Fit SurfaceDistance::fit_triangle(const Point& a, const Point& b, const Point& c, double bound_m) {
  const TrianglePlane plane(a, b, c);
  const auto settle = [&](const PlanePatch& patch, double x0, double y0, int cells) {
    if (patch.empty()) return Verdict::kStop;
    return patch_settles(patch, x0, y0, cells, plane, bound_m, {0, 0}) ? Verdict::kSkip : Verdict::kOpen;
  };
  bool within = walk(plane, settle, [&](std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) {
    return rows_within(plane, x0, y0, x1, y1, bound_m);
  });
  // Edges against the grid's diagonal cross it in the middle of each cell.
  for (std::size_t k = 0; k < 3 && within; ++k) {
    const Point& p = plane.corner[k];
    const Point& q = plane.corner[(k + 1) % 3];
    if ((q.x - p.x) * (q.y - p.y) >= 0) continue;
    const auto x0 = static_cast<std::int64_t>(std::min(p.x, q.x));
    const auto x1 = static_cast<std::int64_t>(std::max(p.x, q.x));
    const auto top = static_cast<std::int64_t>(std::min(p.y, q.y));
    for (std::int64_t x = x0; x < x1 && within; ++x) {
      const std::int64_t y = top + (x1 - 1 - x);
      const double surface = (sample(x, y) + sample(x + 1, y + 1)) / 2;
      within = std::abs(plane.height(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5) - surface) <= bound_m;
    }
  }
  if (within) return Fit::kWithin;
  for (const Point& p : plane.corner) {
    if (!std::isnan(sample(static_cast<std::int64_t>(p.x), static_cast<std::int64_t>(p.y)))) return Fit::kBeyond;
  }
  return any_sample(plane) ? Fit::kBeyond : Fit::kMissing;
}

namespace {

/// Height between two samples of a grid line at share f of the way. A share of nothing must not touch its
/// sample, which may lie beyond the surface's end.
double between(const float* near, std::ptrdiff_t step, double f) {
  if (f < kOnGridLine) return static_cast<double>(*near);
  const auto far = static_cast<double>(near[step]);
  return f > 1 - kOnGridLine ? far : static_cast<double>(*near) + f * (far - static_cast<double>(*near));
}

/// Whole numbers from v0 to v1, whichever is larger.
struct Crossings {
  std::int64_t first;
  std::int64_t last;

  Crossings(double v0, double v1)
      : first(static_cast<std::int64_t>(std::ceil(std::min(v0, v1) - kOnGridLine))),
        last(static_cast<std::int64_t>(std::floor(std::max(v0, v1) + kOnGridLine))) {}
};

/// Narrows the interval by one point of a spoke, at share t of the way from the hub.
inline void clip_point(double t, double residual, double bound_m, HeightInterval& interval) {
  const double weight = 1 - t;
  if (residual - bound_m > interval.lo * weight) interval.lo = (residual - bound_m) / weight;
  if (residual + bound_m < interval.hi * weight) interval.hi = (residual + bound_m) / weight;
}

}  // namespace

void SurfaceDistance::clip_spoke_piece(const Point& hub, const Point& b, double t0, double t1, double bound_m,
                                       HeightInterval& interval) {
  const double dx = b.x - hub.x;
  const double dy = b.y - hub.y;
  const double dz = b.z - hub.z;
  const auto inside = [](double t) { return t > 0 && t < 1; };
  // Nearly every spoke lies in one block, whose samples can then be addressed at once.
  const Window window =
      window_over(std::min(hub.x, b.x), std::min(hub.y, b.y), std::max(hub.x, b.x), std::max(hub.y, b.y));
  const auto run_at = [&](std::int64_t x, std::int64_t y) {
    return window.origin != nullptr ? SampleRun{window.at(x, y), 0, window.base} : this->run_at(x, y);
  };
  if (dx != 0) {
    const double per_column = 1 / dx;
    const Crossings columns(hub.x + t0 * dx, hub.x + t1 * dx);
    for (std::int64_t i = columns.first; i <= columns.last && !interval.empty(); ++i) {
      const double t = (static_cast<double>(i) - hub.x) * per_column;
      if (!inside(t)) continue;
      const double y = hub.y + t * dy;
      const double j = std::floor(y + kOnGridLine);
      const SampleRun run = run_at(i, static_cast<std::int64_t>(j));
      clip_point(t, run.base + between(run.heights, cache::kBlockStride, y - j) - (hub.z + t * dz), bound_m, interval);
    }
  }
  if (dy != 0) {
    const double per_row = 1 / dy;
    const Crossings rows(hub.y + t0 * dy, hub.y + t1 * dy);
    for (std::int64_t j = rows.first; j <= rows.last && !interval.empty(); ++j) {
      const double t = (static_cast<double>(j) - hub.y) * per_row;
      if (!inside(t)) continue;
      const double x = hub.x + t * dx;
      const double i = std::floor(x + kOnGridLine);
      const SampleRun run = run_at(static_cast<std::int64_t>(i), j);
      clip_point(t, run.base + between(run.heights, 1, x - i) - (hub.z + t * dz), bound_m, interval);
    }
  }
  if (dx != dy) {
    const double slant = dx - dy;
    const double start = hub.x - hub.y;
    const double per_diagonal = 1 / slant;
    const Crossings diagonals(start + t0 * slant, start + t1 * slant);
    for (std::int64_t d = diagonals.first; d <= diagonals.last && !interval.empty(); ++d) {
      const double t = (static_cast<double>(d) - start) * per_diagonal;
      if (!inside(t)) continue;
      const double x = hub.x + t * dx;
      const double i = std::floor(x + kOnGridLine);
      const SampleRun run = run_at(static_cast<std::int64_t>(i), static_cast<std::int64_t>(i) - d);
      clip_point(t, run.base + between(run.heights, cache::kBlockStride + 1, x - i) - (hub.z + t * dz), bound_m,
                 interval);
    }
  }
}

bool SurfaceDistance::spoke_square_settled(int size, const Point& hub, const Point& b, double t0, double t1,
                                           std::int64_t x0, std::int64_t y0, double bound_m,
                                           const HeightInterval& interval) const {
  const cache::HeightBlocks& blocks = view_->surface().blocks();
  const std::int64_t column = column0_ + x0;
  const std::int64_t row = row0_ + y0;
  if (column < 0 || row < 0 || column >= blocks.columns() - 1 || row >= blocks.rows() - 1) return false;
  const PlanePatch& patch = view_->surface()
                                .patches(column >> 8, row >> 8)
                                .at(size, static_cast<int>(column & 255), static_cast<int>(row & 255));
  if (patch.empty()) return false;
  for (const double t : {t0, t1}) {
    const double dx = hub.x + t * (b.x - hub.x) - static_cast<double>(x0);
    const double dy = hub.y + t * (b.y - hub.y) - static_cast<double>(y0);
    const double gap =
        hub.z + t * (b.z - hub.z) -
        (static_cast<double>(patch.c) + static_cast<double>(patch.a) * dx + static_cast<double>(patch.b) * dy);
    const double low = gap + (1 - t) * interval.lo - static_cast<double>(patch.high);
    const double high = gap + (1 - t) * interval.hi - static_cast<double>(patch.low);
    if (!(low >= -bound_m) || !(high <= bound_m)) return false;
  }
  return true;
}

/// Walks the squares of one size along a piece of the spoke, and opens those that their patch does not settle.
void SurfaceDistance::walk_spoke(int size, const Point& hub, const Point& b, double t0, double t1, double bound_m,
                                 HeightInterval& interval) {
  const double dx = b.x - hub.x;
  const double dy = b.y - hub.y;
  const int cells = kPatchCells[static_cast<std::size_t>(size)];
  // On a side of two squares: the one that the spoke goes into.
  const auto square = [cells](double v, double step, std::int64_t origin) {
    const double global = v + static_cast<double>(origin) + (step < 0 ? -kOnGridLine : kOnGridLine);
    return static_cast<std::int64_t>(std::floor(global / cells)) * cells - origin;
  };
  const auto leaves_at = [cells](double from, double step, std::int64_t low) {
    return step == 0 ? 1 : (static_cast<double>(step > 0 ? low + cells : low) - from) / step;
  };
  for (double t = t0; t < t1 && !interval.empty();) {
    const std::int64_t x0 = square(hub.x + t * dx, dx, column0_);
    const std::int64_t y0 = square(hub.y + t * dy, dy, row0_);
    const double end = std::max(std::min({t1, leaves_at(hub.x, dx, x0), leaves_at(hub.y, dy, y0)}), t + 1e-12);
    if (!spoke_square_settled(size, hub, b, t, end, x0, y0, bound_m, interval)) {
      if (size > 0)
        walk_spoke(size - 1, hub, b, t, end, bound_m, interval);
      else
        clip_spoke_piece(hub, b, t, end, bound_m, interval);
    }
    t = end;
  }
}

void SurfaceDistance::clip_spoke(const Point& hub, const Point& b, double bound_m, HeightInterval& interval) {
  const auto extent = static_cast<std::int64_t>(std::max(std::abs(b.x - hub.x), std::abs(b.y - hub.y)));
  if (extent < kLarge)
    clip_spoke_piece(hub, b, 0, 1, bound_m, interval);
  else
    walk_spoke(patch_size_for(extent), hub, b, 0, 1, bound_m, interval);
}

}  // namespace tintree::simplify
