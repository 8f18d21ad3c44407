#include "simplify/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace tintree::simplify {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Coordinates this near to a grid line are on it.
constexpr double kSnap = 1e-9;
/// Below this weight the hub cannot move a point measurably: it lies on the old outer edge.
constexpr float kMinWeight = 1e-6F;
/// Triangles and spokes longer than this are settled square by square.
constexpr double kLarge = 24;

// Eight floats at a time; compiled once for the machine's baseline and once for AVX2.
#define TINTREE_CLONES __attribute__((target_clones("avx2", "default")))
using Lanes = float __attribute__((vector_size(32)));
using LaneMask = std::int32_t __attribute__((vector_size(32)));
constexpr int kLanes = 8;

/// One row of samples under a triangle: n samples from `heights`; hub weight and plane height at the first
/// one and their steps.
struct RowSpan {
  const float* heights;
  int n;
  float weight;
  float plane;
};

struct RowSteps {
  float weight;
  float plane;
  float bound;
};

/// Intersects [lo, hi] with the hub heights that each sample of the rows allows.
TINTREE_CLONES void clip_spans(const RowSpan* spans, int count, const RowSteps& steps, float& lo, float& hi) {
  const Lanes iota = {0, 1, 2, 3, 4, 5, 6, 7};
  Lanes best_lo = iota * 0 + lo;
  Lanes best_hi = iota * 0 + hi;
  for (int k = 0; k < count; ++k) {
    const RowSpan& span = spans[k];
    const auto n = static_cast<float>(span.n);
    for (int i = 0; i < span.n; i += kLanes) {
      const Lanes at = iota + static_cast<float>(i);
      const Lanes weight = span.weight + at * steps.weight;
      Lanes h;
      std::memcpy(&h, span.heights + i, sizeof h);
      const Lanes residual = h - (span.plane + at * steps.plane);
      const Lanes inverse = 1.0F / weight;
      const Lanes low = (residual - steps.bound) * inverse;
      const Lanes high = (residual + steps.bound) * inverse;
      const LaneMask counts = (at < n) & (weight > kMinWeight);
      const LaneMask raises = counts & (low > best_lo);
      const LaneMask lowers = counts & (high < best_hi);
      best_lo = raises ? low : best_lo;
      best_hi = lowers ? high : best_hi;
    }
  }
  for (int i = 0; i < kLanes; ++i) {
    lo = std::max(lo, best_lo[i]);
    hi = std::min(hi, best_hi[i]);
  }
}

/// Whether every sample of the row lies within the bound of the plane; false for missing ones too.
TINTREE_CLONES bool span_within(const RowSpan& span, const RowSteps& steps) {
  const Lanes iota = {0, 1, 2, 3, 4, 5, 6, 7};
  const auto n = static_cast<float>(span.n);
  LaneMask bad = {};
  for (int i = 0; i < span.n; i += kLanes) {
    const Lanes at = iota + static_cast<float>(i);
    Lanes h;
    std::memcpy(&h, span.heights + i, sizeof h);
    const Lanes residual = h - (span.plane + at * steps.plane);
    bad |= (at < n) & ~((residual <= steps.bound) & (residual >= -steps.bound));
  }
  int any = 0;
  for (int i = 0; i < kLanes; ++i) any |= bad[i];
  return any == 0;
}

}  // namespace

/// A triangle's height, plane(x, y), and the hub's weight in it, as affine functions; and its outline.
struct SurfaceDistance::Plane {
  double z0, zx, zy;  // height at (0, 0), its slopes
  double w0, wx, wy;  // weight at (0, 0), its slopes
  Point corner[3];
  double slope[3];  // of the edge from corner[i] to corner[i + 1]: dx / dy

  Plane(const Point& hub, const Point& b, const Point& c) : corner{hub, b, c} {
    const double d = (hub.x - c.x) * (b.y - c.y) - (b.x - c.x) * (hub.y - c.y);
    wx = (b.y - c.y) / d;
    wy = (c.x - b.x) / d;
    w0 = -wx * c.x - wy * c.y;
    const double ux = (c.y - hub.y) / d;
    const double uy = (hub.x - c.x) / d;
    const double u0 = -ux * c.x - uy * c.y;
    zx = wx * (hub.z - c.z) + ux * (b.z - c.z);
    zy = wy * (hub.z - c.z) + uy * (b.z - c.z);
    z0 = c.z + w0 * (hub.z - c.z) + u0 * (b.z - c.z);
    for (int i = 0; i < 3; ++i) {
      const Point& p = corner[i];
      const Point& q = corner[(i + 1) % 3];
      slope[i] = p.y == q.y ? 0 : (q.x - p.x) / (q.y - p.y);
    }
  }

  double height(double x, double y) const { return z0 + zx * x + zy * y; }
  double weight(double x, double y) const { return w0 + wx * x + wy * y; }
  double min_x() const { return std::min({corner[0].x, corner[1].x, corner[2].x}); }
  double max_x() const { return std::max({corner[0].x, corner[1].x, corner[2].x}); }
  double min_y() const { return std::min({corner[0].y, corner[1].y, corner[2].y}); }
  double max_y() const { return std::max({corner[0].y, corner[1].y, corner[2].y}); }

  /// The part of row y inside the triangle.
  void span(double y, double& left, double& right) const {
    left = std::numeric_limits<double>::infinity();
    right = -left;
    for (int i = 0; i < 3; ++i) {
      const Point& p = corner[i];
      const Point& q = corner[i == 2 ? 0 : i + 1];
      if ((p.y < y && q.y < y) || (p.y > y && q.y > y)) continue;
      if (p.y == q.y) {
        left = std::min({left, p.x, q.x});
        right = std::max({right, p.x, q.x});
      } else {
        const double x = p.x + (y - p.y) * slope[i];
        left = std::min(left, x);
        right = std::max(right, x);
      }
    }
  }

  /// Whether the square lies wholly outside one of the triangle's edges.
  bool misses(double x0, double y0, double x1, double y1) const {
    for (int i = 0; i < 3; ++i) {
      const Point& p = corner[i];
      const Point& q = corner[(i + 1) % 3];
      const Point& r = corner[(i + 2) % 3];
      const double nx = q.y - p.y;
      const double ny = p.x - q.x;
      const double side = nx * (r.x - p.x) + ny * (r.y - p.y) > 0 ? 1 : -1;
      const double far = std::max(side * nx * (x0 - p.x), side * nx * (x1 - p.x)) +
                         std::max(side * ny * (y0 - p.y), side * ny * (y1 - p.y));
      if (far < 0) return true;
    }
    return false;
  }
};

double guard_m(double range_m, double bound_m) { return range_m * 0x1p-22 + bound_m * 1e-6; }

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
template <typename Plane>
bool patch_settles(const PlanePatch& patch, double x0, double y0, int cells, const Plane& plane, double bound_m,
                   const HeightInterval& interval) {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (int k = 0; k < 4; ++k) {
    const double dx = (k & 1) != 0 ? cells : 0;
    const double dy = (k & 2) != 0 ? cells : 0;
    const double weight = plane.weight(x0 + dx, y0 + dy);
    const double gap = plane.height(x0 + dx, y0 + dy) -
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
bool SurfaceDistance::walk_square(int size, std::int64_t x0, std::int64_t y0, const Plane& plane, const Settle& settle,
                                  const Rows& rows) {
  const int cells = kPatchCells[static_cast<std::size_t>(size)];
  const auto x = static_cast<double>(x0);
  const auto y = static_cast<double>(y0);
  if (plane.misses(x, y, x + cells, y + cells)) return true;
  const std::int64_t column = column0_ + x0;
  const std::int64_t row = row0_ + y0;
  const cache::HeightBlocks& blocks = view_->surface().blocks();
  if (column < 0 || row < 0 || column >= blocks.columns() - 1 || row >= blocks.rows() - 1) return true;
  const PlanePatch& patch = view_->surface().patches(column >> 8, row >> 8)
                                .at(size, static_cast<int>(column & 255), static_cast<int>(row & 255));
  const Verdict verdict = settle(patch, x, y, cells);
  if (verdict != Verdict::kOpen) return verdict == Verdict::kSkip;
  if (size == 0) return rows(x0, y0, x0 + cells, y0 + cells);
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
bool SurfaceDistance::walk(const Plane& plane, const Settle& settle, const Rows& rows) {
  const auto x0 = static_cast<std::int64_t>(std::ceil(plane.min_x() - kSnap));
  const auto y0 = static_cast<std::int64_t>(std::ceil(plane.min_y() - kSnap));
  const auto x1 = static_cast<std::int64_t>(std::floor(plane.max_x() + kSnap));
  const auto y1 = static_cast<std::int64_t>(std::floor(plane.max_y() + kSnap));
  if (static_cast<double>(x1 - x0) < kLarge || static_cast<double>(y1 - y0) < kLarge) return rows(x0, y0, x1, y1);
  const std::int64_t extent = std::max(x1 - x0, y1 - y0);
  const int size = extent < 128 ? 0 : extent < 512 ? 1 : 2;
  const std::int64_t cells = kPatchCells[static_cast<std::size_t>(size)];
  const auto snap_down = [cells](std::int64_t v, std::int64_t origin) { return ((v + origin) & ~(cells - 1)) - origin; };
  for (std::int64_t y = snap_down(y0, row0_); y <= y1; y += cells) {
    for (std::int64_t x = snap_down(x0, column0_); x <= x1; x += cells) {
      if (!walk_square(size, x, y, plane, settle, rows)) return false;
    }
  }
  return true;
}

void SurfaceDistance::clip_rows(const Plane& plane, std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1,
                                double bound_m, HeightInterval& interval) {
  constexpr int kBatch = 32;
  std::array<RowSpan, kBatch> spans;
  const RowSteps steps{static_cast<float>(plane.wx), static_cast<float>(plane.zx), static_cast<float>(bound_m)};
  auto lo = static_cast<float>(interval.lo);
  auto hi = static_cast<float>(interval.hi);
  int count = 0;
  for (std::int64_t y = y0; y <= y1 && lo <= hi; ++y) {
    const auto yd = static_cast<double>(y);
    double left = 0;
    double right = 0;
    plane.span(yd, left, right);
    std::int64_t first = std::max(x0, static_cast<std::int64_t>(std::ceil(left - kSnap)));
    const std::int64_t last = std::min(x1, static_cast<std::int64_t>(std::floor(right + kSnap)));
    while (first <= last) {
      const SampleRun run = run_at(first, y);
      const std::int64_t n = std::min(last - first + 1, run.room);
      const auto xd = static_cast<double>(first);
      spans[static_cast<std::size_t>(count++)] = {run.heights, static_cast<int>(n), static_cast<float>(plane.weight(xd, yd)),
                                                  static_cast<float>(plane.height(xd, yd) - run.base)};
      first += n;
      // Pinned blocks may go when another is fetched, so a batch never spans two.
      if (count == kBatch || first <= last || n == run.room) {
        clip_spans(spans.data(), count, steps, lo, hi);
        count = 0;
      }
    }
    if ((row0_ + y + 1) % cache::kBlockCells == 0) {
      clip_spans(spans.data(), count, steps, lo, hi);
      count = 0;
    }
  }
  clip_spans(spans.data(), count, steps, lo, hi);
  interval.lo = std::max(interval.lo, static_cast<double>(lo));
  interval.hi = std::min(interval.hi, static_cast<double>(hi));
}

bool SurfaceDistance::rows_within(const Plane& plane, std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1,
                                  double bound_m) {
  const RowSteps steps{0, static_cast<float>(plane.zx), static_cast<float>(bound_m)};
  const std::int64_t columns = view_->surface().blocks().columns();
  const std::int64_t rows = view_->surface().blocks().rows();
  for (std::int64_t y = y0; y <= y1; ++y) {
    const auto yd = static_cast<double>(y);
    double left = 0;
    double right = 0;
    plane.span(yd, left, right);
    std::int64_t first = std::max(x0, static_cast<std::int64_t>(std::ceil(left - kSnap)));
    const std::int64_t last = std::min(x1, static_cast<std::int64_t>(std::floor(right + kSnap)));
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

bool SurfaceDistance::any_sample(const Plane& plane) {
  const auto settle = [](const PlanePatch& patch, double, double, int) {
    return patch.empty() ? Verdict::kSkip : Verdict::kOpen;
  };
  return !walk(plane, settle, [&](std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) {
    for (std::int64_t y = y0; y <= y1; ++y) {
      double left = 0;
      double right = 0;
      plane.span(static_cast<double>(y), left, right);
      const std::int64_t last = std::min(x1, static_cast<std::int64_t>(std::floor(right + kSnap)));
      for (auto x = std::max(x0, static_cast<std::int64_t>(std::ceil(left - kSnap))); x <= last; ++x) {
        if (!std::isnan(sample(x, y))) return false;
      }
    }
    return true;
  });
}

void SurfaceDistance::clip_triangle(const Point& hub, const Point& b, const Point& c, double bound_m, HeightInterval& interval) {
  const Plane plane(hub, b, c);
  const auto settle = [&](const PlanePatch& patch, double x0, double y0, int cells) {
    return patch.empty() || patch_settles(patch, x0, y0, cells, plane, bound_m, interval) ? Verdict::kSkip : Verdict::kOpen;
  };
  walk(plane, settle, [&](std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) {
    clip_rows(plane, x0, y0, x1, y1, bound_m, interval);
    return !interval.empty();
  });
}

SurfaceDistance::Fit SurfaceDistance::fit_triangle(const Point& a, const Point& b, const Point& c, double bound_m) {
  const Plane plane(a, b, c);
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
  return any_sample(plane) ? Fit::kBeyond : Fit::kMissing;
}

namespace {

/// Height between two samples of a grid line at share f of the way. A share of nothing must not touch its
/// sample, which may lie beyond the surface's end.
double between(const float* near, std::ptrdiff_t step, double f) {
  if (f < kSnap) return static_cast<double>(*near);
  const auto far = static_cast<double>(near[step]);
  return f > 1 - kSnap ? far : static_cast<double>(*near) + f * (far - static_cast<double>(*near));
}

/// Whole numbers from v0 to v1, whichever is larger.
struct Crossings {
  std::int64_t first;
  std::int64_t last;

  Crossings(double v0, double v1)
      : first(static_cast<std::int64_t>(std::ceil(std::min(v0, v1) - kSnap))),
        last(static_cast<std::int64_t>(std::floor(std::max(v0, v1) + kSnap))) {}
};

/// Narrows the interval by one point of a spoke, at share t of the way from the hub.
void clip_point(double t, double residual, double bound_m, HeightInterval& interval) {
  const double low = (residual - bound_m) / (1 - t);
  const double high = (residual + bound_m) / (1 - t);
  if (low > interval.lo) interval.lo = low;
  if (high < interval.hi) interval.hi = high;
}

}  // namespace

void SurfaceDistance::clip_spoke_piece(const Point& hub, const Point& b, double t0, double t1, double bound_m,
                                       HeightInterval& interval) {
  const double dx = b.x - hub.x;
  const double dy = b.y - hub.y;
  const double dz = b.z - hub.z;
  const auto inside = [](double t) { return t > 0 && t < 1; };
  if (dx != 0) {
    const Crossings columns(hub.x + t0 * dx, hub.x + t1 * dx);
    for (std::int64_t i = columns.first; i <= columns.last && !interval.empty(); ++i) {
      const double t = (static_cast<double>(i) - hub.x) / dx;
      if (!inside(t)) continue;
      const double y = hub.y + t * dy;
      const double j = std::floor(y + kSnap);
      const SampleRun run = run_at(i, static_cast<std::int64_t>(j));
      clip_point(t, run.base + between(run.heights, cache::kBlockStride, y - j) - (hub.z + t * dz), bound_m, interval);
    }
  }
  if (dy != 0) {
    const Crossings rows(hub.y + t0 * dy, hub.y + t1 * dy);
    for (std::int64_t j = rows.first; j <= rows.last && !interval.empty(); ++j) {
      const double t = (static_cast<double>(j) - hub.y) / dy;
      if (!inside(t)) continue;
      const double x = hub.x + t * dx;
      const double i = std::floor(x + kSnap);
      const SampleRun run = run_at(static_cast<std::int64_t>(i), j);
      clip_point(t, run.base + between(run.heights, 1, x - i) - (hub.z + t * dz), bound_m, interval);
    }
  }
  if (dx != dy) {
    const double slant = dx - dy;
    const double start = hub.x - hub.y;
    const Crossings diagonals(start + t0 * slant, start + t1 * slant);
    for (std::int64_t d = diagonals.first; d <= diagonals.last && !interval.empty(); ++d) {
      const double t = (static_cast<double>(d) - start) / slant;
      if (!inside(t)) continue;
      const double x = hub.x + t * dx;
      const double i = std::floor(x + kSnap);
      const SampleRun run = run_at(static_cast<std::int64_t>(i), static_cast<std::int64_t>(i) - d);
      clip_point(t, run.base + between(run.heights, cache::kBlockStride + 1, x - i) - (hub.z + t * dz), bound_m, interval);
    }
  }
}

bool SurfaceDistance::spoke_square_settled(const Point& hub, const Point& b, double t0, double t1, std::int64_t x0,
                                           std::int64_t y0, double bound_m, const HeightInterval& interval) const {
  const cache::HeightBlocks& blocks = view_->surface().blocks();
  const std::int64_t column = column0_ + x0;
  const std::int64_t row = row0_ + y0;
  if (column < 0 || row < 0 || column >= blocks.columns() - 1 || row >= blocks.rows() - 1) return false;
  const PlanePatch& patch =
      view_->surface().patches(column >> 8, row >> 8).at(0, static_cast<int>(column & 255), static_cast<int>(row & 255));
  if (patch.empty()) return false;
  for (const double t : {t0, t1}) {
    const double dx = hub.x + t * (b.x - hub.x) - static_cast<double>(x0);
    const double dy = hub.y + t * (b.y - hub.y) - static_cast<double>(y0);
    const double gap = hub.z + t * (b.z - hub.z) -
                       (static_cast<double>(patch.c) + static_cast<double>(patch.a) * dx + static_cast<double>(patch.b) * dy);
    const double low = gap + (1 - t) * interval.lo - static_cast<double>(patch.high);
    const double high = gap + (1 - t) * interval.hi - static_cast<double>(patch.low);
    if (!(low >= -bound_m) || !(high <= bound_m)) return false;
  }
  return true;
}

void SurfaceDistance::clip_spoke(const Point& hub, const Point& b, double bound_m, HeightInterval& interval) {
  const double dx = b.x - hub.x;
  const double dy = b.y - hub.y;
  if (std::max(std::abs(dx), std::abs(dy)) < kLarge) {
    clip_spoke_piece(hub, b, 0, 1, bound_m, interval);
    return;
  }
  // Walk the finest squares along the spoke and open only those that their patch does not settle.
  constexpr int kCells = kPatchCells[0];
  // On a side of two squares: the one that the spoke goes into.
  const auto square = [](double v, double step, std::int64_t origin) {
    const double global = v + static_cast<double>(origin) + (step < 0 ? -kSnap : kSnap);
    return static_cast<std::int64_t>(std::floor(global / kCells)) * kCells - origin;
  };
  const auto leaves_at = [](double from, double step, std::int64_t low) {
    return step == 0 ? 1 : (static_cast<double>(step > 0 ? low + kCells : low) - from) / step;
  };
  for (double t = 0; t < 1 && !interval.empty();) {
    const std::int64_t x0 = square(hub.x + t * dx, dx, column0_);
    const std::int64_t y0 = square(hub.y + t * dy, dy, row0_);
    const double end = std::max(std::min({1.0, leaves_at(hub.x, dx, x0), leaves_at(hub.y, dy, y0)}), t + 1e-12);
    if (!spoke_square_settled(hub, b, t, end, x0, y0, bound_m, interval)) {
      clip_spoke_piece(hub, b, t, end, bound_m, interval);
    }
    t = end;
  }
}

}  // namespace tintree::simplify
