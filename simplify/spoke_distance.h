#pragma once

#include "simplify/height_interval.h"
#include "simplify/surface_window.h"
#include "simplify/triangle_plane.h"

namespace tintree::simplify {

/// Narrows `interval`, relative to hub.z, to the hub heights that keep the edge from the hub to `end` within
/// `bound_m` of the reference surface at all points where it crosses the grid's rows, columns and diagonals; between
/// them both are straight. The ends are not tested. May stop early once the interval is empty. Long edges are
/// settled from the residual pyramid where that is possible. Cost: about 2 ns a crossing.
void clip_spoke(const SurfaceWindow& surface, const Point& hub, const Point& end, double bound_m,
                HeightInterval& interval);

}  // namespace tintree::simplify
