#pragma once

#include <array>
#include <cstdint>

#include "simplify/height_interval.h"
#include "simplify/triangle_plane.h"
#include "tests/support/test_raster.h"

/// The definitions that the fast checks are compared with: every sample and every crossing, one by one. Places are
/// in quarters of a sample, so that every test of position is exact in integers.
namespace tintree::test {

struct QuarterPoint {
  std::int64_t x;
  std::int64_t y;
  double z;

  simplify::Point point() const { return {static_cast<double>(x) / 4, static_cast<double>(y) / 4, z}; }
};

/// Twice the signed area of (a, b, (x, y)).
std::int64_t cross(const QuarterPoint& a, const QuarterPoint& b, std::int64_t x, std::int64_t y);

/// A part of the raster and where its coordinates begin.
struct BruteSurface {
  const HeightGrid& grid;
  std::int64_t column0 = 0;
  std::int64_t row0 = 0;

  double at(std::int64_t x, std::int64_t y) const { return grid.at(column0 + x, row0 + y); }
};

/// Narrows the interval to the hub heights that bring a point of the given hub weight within the bound.
void narrow(double weight, double residual, double bound, simplify::HeightInterval& interval);

/// What the samples of the closed triangle (hub first), but for those on the side opposite to the hub, leave of the
/// interval.
simplify::HeightInterval brute_triangle(const BruteSurface& surface, const std::array<QuarterPoint, 3>& t, double bound,
                                        simplify::HeightInterval interval);

/// What the crossings of the spoke's inside with rows, columns and diagonals leave of the interval.
simplify::HeightInterval brute_spoke(const BruteSurface& surface, const QuarterPoint& hub, const QuarterPoint& end,
                                     double bound, simplify::HeightInterval interval);

/// `inner` allows no hub height that `outer` forbids, but for the rounding of its ends to float.
bool holds(const simplify::HeightInterval& outer, const simplify::HeightInterval& inner);

}  // namespace tintree::test
