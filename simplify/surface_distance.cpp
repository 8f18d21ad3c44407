#include "simplify/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simplify/patch_sizes.h"
#include "simplify/sample_rect.h"
#include "simplify/spoke_distance.h"
#include "simplify/square_rows.h"

namespace tintree::simplify {
namespace {

/// Below this weight the hub cannot move a point measurably.
constexpr double kMinWeight = 1e-6;
/// Smaller triangles (in cells) have no sample off the outer edge whose weight is that low, or is rounded to it.
constexpr double kAreaOfLightSamples = 0.1 / (kMinWeight * kCornerParts * kCornerParts);
static_assert(kLargeCells < kMaxRectSamples && kPatchCells[0] < kMaxRectSamples);

}  // namespace

double guard_m(double range_m, double bound_m) { return range_m * 0x1p-22 + bound_m * 1e-6; }

namespace {

/// What sums in double of heights so far from 0 may be off by, and the residuals of a patch whose plane is kept in
/// float: twice 24 bits.
double far_guard_m(double farthest_m) { return farthest_m * 0x1p-46; }

}  // namespace

double tested_bound_m(const ReferenceSurface& surface, const codec::CellRect& cells, double bound_m) {
  const cache::HeightBlocks& blocks = surface.blocks();
  const auto heights = surface.height_scale(
      {std::max<std::int64_t>(cells.column0 - 1, 0), std::max<std::int64_t>(cells.row0 - 1, 0),
       std::min(cells.column1 + 1, blocks.columns() - 1), std::min(cells.row1 + 1, blocks.rows() - 1)});
  return bound_m - guard_m(heights.relief_m, bound_m) - far_guard_m(heights.farthest_m);
}

namespace {

/// The largest distance that a linear function with these slopes has over a rectangle from its value in the middle.
double swing(double x, double y, const Extent& r) {
  return (std::abs(x) * (r.x1 - r.x0) + std::abs(y) * (r.y1 - r.y0)) / 2;
}

/// How much the rounding of a test in float may exceed the guard: somewhere in the rectangle the plane is as high as
/// some point of the triangle, but a steep sliver's rises and falls far beyond all heights from there, and its
/// weights do. `reach_m` is how far the hub may move.
double excess_rounding_m(const TrianglePlane& plane, const Extent& r, double reach_m) {
  return guard_m(2 * (swing(plane.zx, plane.zy, r) + swing(plane.wx, plane.wy, r) * reach_m), 0);
}

/// True when the patch alone shows that nothing in the rectangle, part of its square at (x0, y0), narrows the
/// interval: with the hub at either end of it, the triangle's plane stays within the bound of all heights that
/// the patch allows.
bool patch_settles(const PlanePatch& patch, double x0, double y0, const Extent& r, const TrianglePlane& plane,
                   double bound_m, const HeightInterval& interval) {
  const double mx = (r.x0 + r.x1) / 2;
  const double my = (r.y0 + r.y1) / 2;
  const auto a = static_cast<double>(patch.a);
  const auto b = static_cast<double>(patch.b);
  const double gap = plane.height(mx, my) - (static_cast<double>(patch.c) + a * (mx - x0) + b * (my - y0));
  const double weight = plane.weight(mx, my);
  const double slope_x = plane.zx - a;
  const double slope_y = plane.zy - b;
  const double lowest =
      gap + weight * interval.lo - swing(slope_x + plane.wx * interval.lo, slope_y + plane.wy * interval.lo, r);
  const double highest =
      gap + weight * interval.hi + swing(slope_x + plane.wx * interval.hi, slope_y + plane.wy * interval.hi, r);
  return lowest - static_cast<double>(patch.high) >= -bound_m && highest - static_cast<double>(patch.low) <= bound_m;
}

Extent square_extent(std::int64_t x, std::int64_t y, int cells) {
  const auto x0 = static_cast<double>(x);
  const auto y0 = static_cast<double>(y);
  return {x0, y0, x0 + cells, y0 + cells};
}

/// The squares of a size from the one that holds `low` (relative to a tile at `origin`).
std::int64_t square_start(double low, std::int64_t origin, int cells) {
  const auto v = static_cast<std::int64_t>(std::floor(low)) + origin;
  return (v & ~(std::int64_t{cells} - 1)) - origin;
}

}  // namespace

template <typename Visit>
bool SurfaceDistance::for_each_rect(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1,
                                    const Visit& visit) {
  if (x1 < x0) return true;
  for (std::int64_t y = y0; y <= y1;) {
    std::int64_t rows = 0;
    for (std::int64_t x = x0; x <= x1;) {
      const SampleRun run = window_.run_at(x, y);
      const std::int64_t columns = std::min(x1 - x + 1, run.columns);
      rows = std::min(y1 - y + 1, run.rows);
      if (!visit(SampleRect{run.heights, static_cast<int>(columns), static_cast<int>(rows)}, x, y, run.base_m))
        return false;
      x += columns;
    }
    y += rows;
  }
  return true;
}

/// Puts the squares under a part of a triangle, which lies on the DEM, on the list of their size. A square has all
/// samples on its sides, so those beyond the part's last column and row are not needed.
void SurfaceDistance::add_squares(int size, std::uint32_t plane, const Extent& extent) {
  const int cells = kPatchCells[static_cast<std::size_t>(size)];
  const std::int64_t west = square_start(extent.x0, window_.column0(), cells);
  const std::int64_t north = square_start(extent.y0, window_.row0(), cells);
  std::vector<Square>& list = squares_[static_cast<std::size_t>(size)];
  const SquareRows rows(planes_[plane], square_extent(west, north, cells), extent);
  for (std::int64_t y = north; static_cast<double>(y) < extent.y1; y += cells) {
    const SquareRows::Columns columns = rows.at(y - north);
    const int row = static_cast<int>((window_.row0() + y) & 255);
    const PlanePatch* patch = nullptr;
    const std::int64_t end = west + columns.end * cells;
    for (std::int64_t x = west + columns.first * cells; x < end; x += cells, ++patch) {
      const int column = static_cast<int>((window_.column0() + x) & 255);
      if (patch == nullptr || column == 0) patch = &window_.patches_at(x, y).at(size, column, row);
      if (!patch->empty()) list.push_back({patch, x, y, plane});
    }
  }
}

/// Works off the squares of one size: what is left open goes to the next smaller one, or to open_.
void SurfaceDistance::clip_squares(int size, double bound_m, HeightInterval& interval) {
  const int cells = kPatchCells[static_cast<std::size_t>(size)];
  const std::vector<Square>& squares = squares_[static_cast<std::size_t>(size)];
  if (size < 2) {
    for (const Square& s : squares) {
      const TrianglePlane& plane = planes_[s.plane];
      const auto test = [&](std::uint8_t i, std::uint8_t j, float offset) {
        const double x = static_cast<double>(s.x0) + i;
        const double y = static_cast<double>(s.y0) + j;
        const double weight = plane.weight(x, y);
        if (!(weight > kMinWeight) || !plane.contains(x, y)) return;
        const double height = static_cast<double>(s.patch->c) + static_cast<double>(s.patch->a) * i +
                              static_cast<double>(s.patch->b) * j + static_cast<double>(offset);
        interval.clip(weight, height - plane.height(x, y), bound_m);
      };
      test(s.patch->low_x, s.patch->low_y, s.patch->low);
      test(s.patch->high_x, s.patch->high_y, s.patch->high);
      if (interval.empty()) return;
    }
  }
  for (const Square& s : squares) {
    const TrianglePlane& plane = planes_[s.plane];
    const Extent part = overlap(plane.extent, square_extent(s.x0, s.y0, cells));
    if (patch_settles(*s.patch, static_cast<double>(s.x0), static_cast<double>(s.y0), part, plane, bound_m, interval))
      continue;
    if (size > 0)
      add_squares(size - 1, s.plane, part);
    else
      open_.push_back(s);
  }
}

void SurfaceDistance::clip_samples(const TrianglePlane& plane, const Extent& extent, double bound_m,
                                   HeightInterval& interval) {
  auto lo = static_cast<float>(interval.lo);
  auto hi = static_cast<float>(interval.hi);
  const double reach = std::max(std::abs(interval.lo), std::abs(interval.hi));
  const auto tested = static_cast<float>(bound_m - excess_rounding_m(plane, extent, reach));
  for_each_rect(static_cast<std::int64_t>(std::ceil(extent.x0)), static_cast<std::int64_t>(std::ceil(extent.y0)),
                static_cast<std::int64_t>(std::floor(extent.x1)), static_cast<std::int64_t>(std::floor(extent.y1)),
                [&](const SampleRect& samples, std::int64_t x, std::int64_t y, double base) {
                  clip_rect(samples, plane.over(x, y, base), tested, plane.area > kAreaOfLightSamples, lo, hi);
                  return lo <= hi;
                });
  interval.lo = std::max(interval.lo, static_cast<double>(lo));
  interval.hi = std::min(interval.hi, static_cast<double>(hi));
}

/// What the squares have left open, sample by sample.
void SurfaceDistance::clip_open(double bound_m, HeightInterval& interval) {
  for (const Square& s : open_) {
    const TrianglePlane& plane = planes_[s.plane];
    Extent part = overlap(plane.extent, square_extent(s.x0, s.y0, kPatchCells[0]));
    if (patch_settles(*s.patch, static_cast<double>(s.x0), static_cast<double>(s.y0), part, plane, bound_m, interval))
      continue;
    // Samples on a common side are left to the next square where the triangle goes on.
    if (part.x1 < plane.extent.x1) part.x1 -= 1;
    if (part.y1 < plane.extent.y1) part.y1 -= 1;
    clip_samples(plane, part, bound_m, interval);
    if (interval.empty()) return;
  }
}

void SurfaceDistance::clip_star(const Star& star, HeightInterval& interval) {
  planes_.clear();
  open_.clear();
  for (auto& list : squares_) list.clear();
  for (std::uint32_t k = 0; k < star.sides.size(); ++k) {
    const Star::Side& side = star.sides[k];
    const TrianglePlane& plane = planes_.emplace_back(star.hub, side.from, side.to);
    const double length = std::max(plane.extent.x1 - plane.extent.x0, plane.extent.y1 - plane.extent.y0);
    if (length < kLargeCells) {
      clip_samples(plane, plane.extent, star.bound_m, interval);
      if (interval.empty()) return;
    } else {
      add_squares(patch_size_for(length), k, plane.extent);
    }
  }
  for (int size = 2; size >= 0; --size) {
    clip_squares(size, star.bound_m, interval);
    if (interval.empty()) return;
  }
  for (const Star::Spoke& spoke : star.spokes) {
    clip_spoke(window_, star.hub, spoke.end, spoke.bound_m, interval);
    if (interval.empty()) return;
  }
  clip_open(star.bound_m, interval);
}

/// Whether all samples of a part of the triangle lie within the bound of its plane.
bool SurfaceDistance::within(int size, const TrianglePlane& plane, const Extent& extent, double bound_m) {
  if (size < 0) {
    const auto tested = static_cast<float>(bound_m - excess_rounding_m(plane, extent, 0));
    return for_each_rect(static_cast<std::int64_t>(extent.x0), static_cast<std::int64_t>(extent.y0),
                         static_cast<std::int64_t>(extent.x1), static_cast<std::int64_t>(extent.y1),
                         [&](const SampleRect& samples, std::int64_t x, std::int64_t y, double base) {
                           return rect_within(samples, plane.over(x, y, base), tested);
                         });
  }
  const int cells = kPatchCells[static_cast<std::size_t>(size)];
  for (std::int64_t y = square_start(extent.y0, window_.row0(), cells); static_cast<double>(y) < extent.y1;
       y += cells) {
    for (std::int64_t x = square_start(extent.x0, window_.column0(), cells); static_cast<double>(x) < extent.x1;
         x += cells) {
      const Extent square = square_extent(x, y, cells);
      if (plane.misses(square)) continue;
      const PlanePatch& patch = *window_.patch_at(size, x, y);
      if (patch.empty()) return false;
      const Extent part = overlap(extent, square);
      if (patch_settles(patch, square.x0, square.y0, part, plane, bound_m, {0, 0})) continue;
      if (!within(size - 1, plane, part, bound_m)) return false;
    }
  }
  return true;
}

/// Whether any sample lies in a part of the triangle that reaches nowhere beyond the DEM.
bool SurfaceDistance::any_sample(int size, const TrianglePlane& plane, const Extent& extent) {
  const int cells = kPatchCells[static_cast<std::size_t>(size)];
  // The last column and row belong to the squares before them.
  const double last_x = window_.extent().x1 - 1;
  const double last_y = window_.extent().y1 - 1;
  const std::int64_t x0 = square_start(std::min(extent.x0, last_x), window_.column0(), cells);
  const std::int64_t y0 = square_start(std::min(extent.y0, last_y), window_.row0(), cells);
  for (std::int64_t y = y0; static_cast<double>(y) <= std::min(extent.y1, last_y); y += cells) {
    for (std::int64_t x = x0; static_cast<double>(x) <= std::min(extent.x1, last_x); x += cells) {
      const Extent square = square_extent(x, y, cells);
      if (plane.misses(square) || window_.patch_at(size, x, y)->empty()) continue;
      const Extent part = overlap(extent, square);
      if (size > 0) {
        if (any_sample(size - 1, plane, part)) return true;
        continue;
      }
      for (auto j = static_cast<std::int64_t>(part.y0); static_cast<double>(j) <= part.y1; ++j) {
        for (auto i = static_cast<std::int64_t>(part.x0); static_cast<double>(i) <= part.x1; ++i) {
          const bool inside = plane.contains(static_cast<double>(i), static_cast<double>(j));
          if (inside && !std::isnan(window_.sample(i, j))) return true;
        }
      }
    }
  }
  return false;
}

SurfaceDistance::Fit SurfaceDistance::fit_triangle(const Point& a, const Point& b, const Point& c, double bound_m) {
  const TrianglePlane plane(a, b, c);
  const Extent extent = plane.extent;
  const double length = std::max(extent.x1 - extent.x0, extent.y1 - extent.y0);
  const int size = length < kLargeCells ? -1 : patch_size_for(length);
  bool fits = window_.extent().holds(extent) && within(size, plane, extent, bound_m);
  // Edges against the grid's diagonal cross it in the middle of each cell.
  for (std::size_t k = 0; k < 3 && fits; ++k) {
    const Point& p = plane.corner[k];
    const Point& q = plane.corner[(k + 1) % 3];
    if ((q.x - p.x) * (q.y - p.y) >= 0) continue;
    const auto x0 = static_cast<std::int64_t>(std::min(p.x, q.x));
    const auto x1 = static_cast<std::int64_t>(std::max(p.x, q.x));
    const auto top = static_cast<std::int64_t>(std::min(p.y, q.y));
    for (std::int64_t x = x0; x < x1 && fits; ++x) {
      const std::int64_t y = top + (x1 - 1 - x);
      const double surface = (window_.sample(x, y) + window_.sample(x + 1, y + 1)) / 2;
      fits = std::abs(plane.height(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5) - surface) <= bound_m;
    }
  }
  if (fits) return Fit::kWithin;
  for (const Point& p : plane.corner) {
    if (!std::isnan(window_.sample(static_cast<std::int64_t>(p.x), static_cast<std::int64_t>(p.y))))
      return Fit::kBeyond;
  }
  const Extent in_dem = overlap(extent, window_.extent());
  return !in_dem.empty() && any_sample(std::max(size, 0), plane, in_dem) ? Fit::kBeyond : Fit::kMissing;
}

}  // namespace tintree::simplify
