#pragma once

#include <cstdint>

#include "simplify/reference_surface.h"
#include "simplify/triangle_plane.h"

namespace tintree::simplify {

/// Heights that a vertex may take, relative to a height that the caller chose. Empty when lo > hi.
struct HeightInterval {
  double lo = 0;
  double hi = 0;

  bool empty() const { return lo > hi; }
};

/// Exact vertical distance between a triangle and the reference surface, the check that every collapse has
/// to pass (docs/accuracy.md). On each cell of the overlay of the two triangulations both surfaces are
/// planar, so their largest difference lies at the overlay's vertices: samples, mesh vertices, and
/// crossings of mesh edges with the grid's rows, columns and diagonals. The new triangles of a collapse
/// share one vertex, the hub, and at each overlay vertex their height is linear in the hub's height:
/// each gives an interval of allowed hub heights, and their intersection is exact.
///
/// Samples are tested in float against a bound that the caller has lowered by guard_m(), which covers
/// the rounding. Large triangles are decided square by square from the residual pyramid where that is
/// possible. Cost: about 1 ns a sample, 5 ns a crossing. Not thread-safe.
class SurfaceDistance {
 public:
  /// Points are given relative to sample (column0, row0).
  SurfaceDistance(SurfaceView& view, std::int64_t column0, std::int64_t row0)
      : view_(&view), column0_(column0), row0_(row0) {}

  /// Height of the surface at a point of its domain (its own z is not used); NaN outside.
  double height_at(double x, double y);
  /// Height of the sample at whole coordinates, NaN when missing.
  double sample(std::int64_t x, std::int64_t y) { return view_->sample(column0_ + x, row0_ + y); }
  /// SurfaceView::interrupted().
  bool interrupted() { return view_->interrupted(); }

  /// Narrows `interval`, relative to hub.z, to the hub heights that keep triangle (hub, b, c) within
  /// `bound_m` of every sample inside it. The side (b, c) is not tested: it is an old edge. Stops early
  /// once the interval is empty.
  void clip_triangle(const Point& hub, const Point& b, const Point& c, double bound_m, HeightInterval& interval);

  /// The same for the points where the edge from the hub to `b` crosses the grid's lines.
  void clip_spoke(const Point& hub, const Point& b, double bound_m, HeightInterval& interval);

  /// Whether a fixed triangle with corners at samples stays within `bound_m` of the surface at every sample
  /// of it, and along each of its edges, and no sample of it is missing. All its edges run along rows,
  /// columns or diagonals of either direction.
  enum class Fit { kWithin, kBeyond, kMissing };
  Fit fit_triangle(const Point& a, const Point& b, const Point& c, double bound_m);

 private:
  struct SampleRun;
  struct Window;
  SampleRun run_at(std::int64_t x, std::int64_t y);
  Window window_over(double x0, double y0, double x1, double y1);
  template <typename Settle, typename Rows>
  bool walk_square(int size, std::int64_t x0, std::int64_t y0, const TrianglePlane& plane, const Settle& settle,
                   const Rows& rows);
  template <typename Settle, typename Rows>
  bool walk(const TrianglePlane& plane, const Settle& settle, const Rows& rows);
  void clip_rows(const TrianglePlane& plane, std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1,
                 double bound_m, HeightInterval& interval);
  bool rows_within(const TrianglePlane& plane, std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1,
                   double bound_m);
  bool any_sample(const TrianglePlane& plane);
  bool spoke_square_settled(int size, const Point& hub, const Point& b, double t0, double t1, std::int64_t x0,
                            std::int64_t y0, double bound_m, const HeightInterval& interval) const;
  void walk_spoke(int size, const Point& hub, const Point& b, double t0, double t1, double bound_m,
                  HeightInterval& interval);
  void clip_spoke_piece(const Point& hub, const Point& b, double t0, double t1, double bound_m,
                        HeightInterval& interval);

  SurfaceView* view_;
  std::int64_t column0_;
  std::int64_t row0_;
};

/// How much a bound has to be lowered for tests in float to hold exactly, over heights that span `range_m`.
double guard_m(double range_m, double bound_m);

/// `bound_m` less the guard for everything that is tested over `cells`. Neighbouring blocks hold their common
/// samples twice, each relative to its own base, so the heights next to the cells count too. A function of the
/// place alone: whoever tests there gets the same.
double tested_bound_m(const ReferenceSurface& surface, const codec::CellRect& cells, double bound_m);

}  // namespace tintree::simplify
