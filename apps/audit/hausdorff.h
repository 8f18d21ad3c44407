#pragma once

#include <array>
#include <vector>

namespace tintree::audit {

using Point = std::array<double, 3>;
using TriangleSoup = std::vector<std::array<Point, 3>>;

/// The symmetric Hausdorff distance of two triangulated surfaces as CGAL computes it, within `error_bound`
/// (greater than 0). CGAL returns at least the bound asked for, even where the surfaces are nearer.
/// Seconds for tens of thousands of triangles. Neither soup may be empty.
double symmetric_hausdorff(const TriangleSoup& one, const TriangleSoup& other, double error_bound);

}  // namespace tintree::audit
