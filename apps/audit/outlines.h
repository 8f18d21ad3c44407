#pragma once

#include <cstdint>
#include <span>

#include "apps/audit/view_frame.h"

namespace tintree::audit {

struct OutlineCounts {
  std::uint64_t crack_px = 0;       ///< Background drawn where the surface is seen,
  std::uint64_t silhouette_px = 0;  ///< terrain drawn where it is not; each farther than the reach from its outline.
};

/// Compares where terrain was drawn (`drawn_m` is finite) with where the surface is seen. Ridges narrower than the
/// distance of pixels and holes of any size count as outlines. On all cores; a few rays a pixel at outlines.
Expected<OutlineCounts> compare_outlines(const SeenSurface& seen, std::span<const double> drawn_m);

}  // namespace tintree::audit
