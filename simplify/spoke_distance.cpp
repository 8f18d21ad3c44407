#include "simplify/spoke_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "simplify/patch_sizes.h"

namespace tintree::simplify {
namespace {

/// The edge from the hub at t = 0 to its end at t = 1.
struct Spoke {
  Point hub;
  double dx, dy, dz;

  double x(double t) const { return hub.x + t * dx; }
  double y(double t) const { return hub.y + t * dy; }
  double z(double t) const { return hub.z + t * dz; }
};

/// Crossings with the grid lines of one direction, one line after the other. A line's samples are `along` apart
/// and those of neighbouring lines that face each other `across`; the k-th crossing is at t + k dt, at place
/// v + k dv between the samples of its line.
struct Crossings {
  const float* origin;  ///< The sample at place 0 of the first line.
  int along;
  int across;
  int count;
  double v, dv;
  double t, dt;
  int least, most, shift;  ///< Places of the k-th line's samples: from least + k shift to most + k shift, and one more;
  int limit;               ///< but none beyond limit + 1.

  /// The place of the sample before the k-th crossing. Rounding must not reach beyond the block.
  int cell(int k) const {
    return std::max(std::min({static_cast<int>(v + k * dv), most + k * shift, limit}), least + k * shift);
  }
};

/// Crossings that are tested at a time.
constexpr int kLanes = 4;

/// Whether any crossing narrows the interval. `z` and `dz` are the edge's height, relative to the samples' base, and
/// its rise over all of t. All samples exist.
__attribute__((target_clones("avx2", "default"))) bool narrows(const Crossings& c, double z, double dz, double bound_m,
                                                               double lo, double hi) {
  int found = 0;
  for (int first = 0; first < c.count; first += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane) {
      // The last one again and again, so that all lanes have something to do.
      const int k = std::min(first + lane, c.count - 1);
      const double v = c.v + k * c.dv;
      const double t = c.t + k * c.dt;
      const int cell = c.cell(k);
      const int near = cell * c.along + k * c.across;
      const double from = c.origin[near];
      const double to = c.origin[near + c.along];
      const double residual = from + (v - cell) * (to - from) - (z + t * dz);
      const double weight = 1 - t;
      found |= static_cast<int>(residual - bound_m > lo * weight) | static_cast<int>(residual + bound_m < hi * weight);
    }
  }
  return found != 0;
}

void clip_crossings(const Crossings& c, double z, double dz, double bound_m, HeightInterval& interval) {
  if (c.count <= 0 || !narrows(c, z, dz, bound_m, interval.lo, interval.hi)) return;
  for (int k = 0; k < c.count; ++k) {
    const double v = c.v + k * c.dv;
    const double t = c.t + k * c.dt;
    const int cell = c.cell(k);
    const float* near = c.origin + (cell * c.along + k * c.across);
    const double from = near[0];
    const double to = near[c.along];
    interval.clip(1 - t, from + (v - cell) * (to - from) - (z + t * dz), bound_m);
  }
}

/// The whole numbers strictly between the ends of an edge whose coordinate runs from `start` by `step`, and within
/// its piece [t0, t1].
struct Lines {
  std::int64_t first = 0;
  std::int64_t last = -1;

  Lines(double start, double step, double t0, double t1) {
    if (step == 0) return;
    const double from = std::min(start + t0 * step, start + t1 * step);
    const double to = std::max(start + t0 * step, start + t1 * step);
    first = static_cast<std::int64_t>(std::ceil(from - kOnGridLine));
    last = static_cast<std::int64_t>(std::floor(to + kOnGridLine));
    const double low = std::min(start, start + step);
    const double high = std::max(start, start + step);
    if (static_cast<double>(first) <= low) ++first;
    if (static_cast<double>(last) >= high) --last;
  }
};

/// A piece of the spoke inside one block without missing samples; `run` begins at sample (x0, y0).
void clip_in_block(const SampleRun& run, std::int64_t x0, std::int64_t y0, const Spoke& s, double t0, double t1,
                   double bound_m, HeightInterval& interval) {
  const double z = s.hub.z - run.base_m;
  const auto west = static_cast<double>(x0);
  const auto north = static_cast<double>(y0);
  constexpr int kRow = cache::kBlockStride;
  const auto columns_room = static_cast<int>(run.columns);
  const auto rows_room = static_cast<int>(run.rows);
  const auto clip = [&](const Lines& lines, double start, double step, double v0, double dv, Crossings c) {
    if (lines.first > lines.last || interval.empty()) return;
    c.dt = 1 / step;
    c.t = (static_cast<double>(lines.first) - start) * c.dt;
    c.v = v0 + c.t * dv;
    c.dv = dv * c.dt;
    c.count = static_cast<int>(lines.last - lines.first + 1);
    clip_crossings(c, z, s.dz, bound_m, interval);
  };
  Crossings c{};
  const Lines columns(s.hub.x, s.dx, t0, t1);
  c.origin = run.heights + (columns.first - x0);
  c.along = kRow;
  c.across = 1;
  c.most = c.limit = rows_room - 2;
  clip(columns, s.hub.x, s.dx, s.hub.y - north, s.dy, c);
  const Lines rows(s.hub.y, s.dy, t0, t1);
  c.origin = run.heights + (rows.first - y0) * kRow;
  c.along = 1;
  c.across = kRow;
  c.most = c.limit = columns_room - 2;
  clip(rows, s.hub.y, s.dy, s.hub.x - west, s.dx, c);
  // Diagonal d joins the samples with x - y = d; here it meets row 0 at place `top`.
  const Lines diagonals(s.hub.x - s.hub.y, s.dx - s.dy, t0, t1);
  const auto top = static_cast<int>(diagonals.first - x0 + y0);
  c.origin = run.heights - top * kRow;
  c.along = kRow + 1;
  c.across = -kRow;
  c.least = top;
  c.most = top + rows_room - 2;
  c.shift = 1;
  clip(diagonals, s.hub.x - s.hub.y, s.dx - s.dy, s.hub.x - west, s.dx, c);
}

/// Height between two samples of a grid line at share f of the way. A share of nothing must not touch its
/// sample, which may lie beyond the surface's end.
double between(double near, double far, double f) {
  if (f < kOnGridLine) return near;
  return f > 1 - kOnGridLine ? far : near + f * (far - near);
}

/// The same where samples may be missing, or lie in several blocks.
void clip_anywhere(const SurfaceWindow& surface, const Spoke& s, double t0, double t1, double bound_m,
                   HeightInterval& interval) {
  const auto clip = [&](double start, double step, const auto& height) {
    const Lines lines(start, step, t0, t1);
    for (std::int64_t i = lines.first; i <= lines.last && !interval.empty(); ++i) {
      const double t = (static_cast<double>(i) - start) / step;
      interval.clip(1 - t, height(i, t) - s.z(t), bound_m);
    }
  };
  clip(s.hub.x, s.dx, [&](std::int64_t i, double t) {
    const double j = std::floor(s.y(t) + kOnGridLine);
    const auto row = static_cast<std::int64_t>(j);
    return between(surface.sample(i, row), surface.sample(i, row + 1), s.y(t) - j);
  });
  clip(s.hub.y, s.dy, [&](std::int64_t row, double t) {
    const double i = std::floor(s.x(t) + kOnGridLine);
    const auto column = static_cast<std::int64_t>(i);
    return between(surface.sample(column, row), surface.sample(column + 1, row), s.x(t) - i);
  });
  clip(s.hub.x - s.hub.y, s.dx - s.dy, [&](std::int64_t d, double t) {
    const double i = std::floor(s.x(t) + kOnGridLine);
    const auto column = static_cast<std::int64_t>(i);
    return between(surface.sample(column, column - d), surface.sample(column + 1, column + 1 - d), s.x(t) - i);
  });
}

void clip_piece(const SurfaceWindow& surface, const Spoke& s, double t0, double t1, double bound_m,
                HeightInterval& interval) {
  const double x0 = std::min(s.x(t0), s.x(t1));
  const double y0 = std::min(s.y(t0), s.y(t1));
  const double x1 = std::max(s.x(t0), s.x(t1));
  const double y1 = std::max(s.y(t0), s.y(t1));
  const auto west = static_cast<std::int64_t>(std::floor(x0 + kOnGridLine));
  const auto north = static_cast<std::int64_t>(std::floor(y0 + kOnGridLine));
  const SampleRun run = surface.run_at(west, north);
  // The raster's last column and row have no next one in their block.
  if (run.all_valid && run.columns > 1 && run.rows > 1 &&
      x1 <= static_cast<double>(west + run.columns - 1) + kOnGridLine &&
      y1 <= static_cast<double>(north + run.rows - 1) + kOnGridLine) {
    clip_in_block(run, west, north, s, t0, t1, bound_m, interval);
  } else {
    clip_anywhere(surface, s, t0, t1, bound_m, interval);
  }
}

/// True when the patch alone shows that the piece of the spoke in its square at (x0, y0) does not narrow the interval.
bool patch_settles(const PlanePatch& patch, const Spoke& s, double t0, double t1, double x0, double y0, double bound_m,
                   const HeightInterval& interval) {
  for (const double t : {t0, t1}) {
    const double gap = s.z(t) - (static_cast<double>(patch.c) + static_cast<double>(patch.a) * (s.x(t) - x0) +
                                 static_cast<double>(patch.b) * (s.y(t) - y0));
    const double low = gap + (1 - t) * interval.lo - static_cast<double>(patch.high);
    const double high = gap + (1 - t) * interval.hi - static_cast<double>(patch.low);
    if (!(low >= -bound_m) || !(high <= bound_m)) return false;
  }
  return true;
}

/// Walks the squares of one size along a piece of the spoke, and opens those that their patch does not settle.
void walk(const SurfaceWindow& surface, int size, const Spoke& s, double t0, double t1, double bound_m,
          HeightInterval& interval) {
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
    const std::int64_t x0 = square(s.x(t), s.dx, surface.column0());
    const std::int64_t y0 = square(s.y(t), s.dy, surface.row0());
    const double leaves = std::min(leaves_at(s.hub.x, s.dx, x0), leaves_at(s.hub.y, s.dy, y0));
    const double end = std::max(std::min(t1, leaves), t + 1e-12);
    const PlanePatch* patch = surface.patch_at(size, x0, y0);
    if (patch == nullptr || patch->empty() ||
        !patch_settles(*patch, s, t, end, static_cast<double>(x0), static_cast<double>(y0), bound_m, interval)) {
      if (size > 0)
        walk(surface, size - 1, s, t, end, bound_m, interval);
      else
        clip_piece(surface, s, t, end, bound_m, interval);
    }
    t = end;
  }
}

}  // namespace

void clip_spoke(const SurfaceWindow& surface, const Point& hub, const Point& end, double bound_m,
                HeightInterval& interval) {
  const Spoke s{hub, end.x - hub.x, end.y - hub.y, end.z - hub.z};
  const double extent = std::max(std::abs(s.dx), std::abs(s.dy));
  if (extent < kLargeCells)
    clip_piece(surface, s, 0, 1, bound_m, interval);
  else
    walk(surface, patch_size_for(extent), s, 0, 1, bound_m, interval);
}

}  // namespace tintree::simplify
