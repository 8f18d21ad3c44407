#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "apps/audit/drawn_mesh_rays.h"
#include "apps/audit/view_frame.h"

namespace tintree::audit {

/// How far drivers draw from what they are told: they place vertices on a lattice of 1/256 of a pixel and interpolate
/// in single precision.
inline constexpr double kDriverPx = 0.05;

struct DrawnPoints {
  double max_px = 0;           ///< How far a drawn point is from the surface at most.
  std::uint64_t amiss_px = 0;  ///< Pixels that the driver drew amiss, and whose exact points stand in.
};

/// Compares the points that a depth buffer without skirts holds (`drawn_m`, along the view; kMiss where there is none)
/// with the surface above, below or (on walls) beside them. Where depth jumps, an outline may be off by the limit:
/// there the depth has to be one that the surface has within that many pixels.
///
/// A triangle seen edge-on, far thinner than the driver's lattice, may come out with a depth from far outside it. So
/// single pixels beyond the limit and kDriverPx are looked at again in double precision: where the point is on none of
/// the meshes within kDriverPx, the driver drew what is not there, and the mesh point that the pixel's ray meets first
/// is compared in its place, by the same limit. More than one pixel in 10 000 is more than such triangles explain: then
/// all count as they are drawn. `meshes` is called once when they are needed; without it all count as drawn, too. On
/// all cores.
Expected<DrawnPoints> compare_drawn_points(const SeenSurface& seen, std::span<const double> drawn_m,
                                           const std::function<Expected<DrawnMeshRays>()>& meshes);

}  // namespace tintree::audit
