#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "simplify/height_interval.h"
#include "simplify/surface_window.h"
#include "simplify/triangle_plane.h"

namespace tintree::simplify {

/// The triangles around a vertex, the hub.
struct Star {
  /// The side of a triangle that is opposite to the hub.
  struct Side {
    Point from;
    Point to;
  };
  /// The end of an edge from the hub, and the bound along it.
  struct Spoke {
    Point end;
    double bound_m;
  };

  Point hub;
  double bound_m = 0;
  std::vector<Side> sides;
  std::vector<Spoke> spokes;
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
/// possible: first the extreme samples of all squares, which mostly narrow the interval to its final size or to
/// nothing, then what they leave open. Stars that are tested one after the other are often of nearly the same ring:
/// sides that have emptied an interval come first in the next. Cost: about 0.3 ns a sample, 5 ns a crossing. Not
/// thread-safe.
class SurfaceDistance {
 public:
  /// Points are given relative to sample (column0, row0), on multiples of 1 / kCornerParts samples.
  SurfaceDistance(SurfaceView& view, std::int64_t column0, std::int64_t row0) : window_(view, column0, row0) {}

  const SurfaceWindow& surface() const { return window_; }
  /// SurfaceView::interrupted().
  bool interrupted() const { return window_.interrupted(); }

  /// Narrows `interval`, relative to the hub's z, to the hub heights that keep all triangles of the star within
  /// the bound of every sample in them, and its spokes within theirs of every point where they cross the grid's
  /// lines. The sides opposite to the hub are not tested: they are old edges. Stops early once the interval is
  /// empty.
  void clip_star(const Star& star, HeightInterval& interval);

  /// Whether a fixed triangle with corners at samples stays within `bound_m` of the surface at every sample
  /// of it, and along each of its edges, and no sample of it is missing. All its edges run along rows,
  /// columns or diagonals of either direction.
  enum class Fit { kWithin, kBeyond, kMissing };
  Fit fit_triangle(const Point& a, const Point& b, const Point& c, double bound_m);

 private:
  /// A square of the residual pyramid under one of the triangles; (x0, y0) is its first sample.
  struct Square {
    const PlanePatch* patch;
    std::int64_t x0;
    std::int64_t y0;
    std::uint32_t plane;
  };

  /// Calls `visit(samples, x, y, base)` for the parts of a rectangle of samples that lie in one block each; stops
  /// when it returns false, and returns what the last call did.
  template <typename Visit>
  bool for_each_rect(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1, const Visit& visit);
  void add_squares(int size, std::uint32_t plane, const Extent& extent);
  void clip_squares(int size, double bound_m, HeightInterval& interval);
  void clip_open(double bound_m, HeightInterval& interval);
  void clip_samples(const TrianglePlane& plane, const Extent& extent, double bound_m, HeightInterval& interval);
  bool within(int size, const TrianglePlane& plane, const Extent& extent, double bound_m);
  bool any_sample(int size, const TrianglePlane& plane, const Extent& extent);
  void blame(std::uint32_t plane);

  SurfaceWindow window_;
  std::vector<std::uint32_t> order_;            // of a star's sides
  std::vector<TrianglePlane> planes_;           // of the sides in that order
  std::array<std::vector<Square>, 3> squares_;  // by size
  std::vector<Square> open_;
};

/// How much a bound has to be lowered for tests in float to hold exactly, over heights that span `range_m`.
double guard_m(double range_m, double bound_m);

/// `bound_m` less the guard for everything that is tested over `cells`. Neighbouring blocks hold their common
/// samples twice, each relative to its own base, so the heights next to the cells count too. A function of the
/// place alone: whoever tests there gets the same.
double tested_bound_m(const ReferenceSurface& surface, const codec::CellRect& cells, double bound_m);

}  // namespace tintree::simplify
