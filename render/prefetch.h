#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "cache/tile_ref.h"
#include "render/camera.h"
#include "render/lod_cut.h"
#include "render/texture_parts.h"

namespace tintree::render {

/// Where a camera has been, and where it will be if it goes on like that. A plain value.
class CameraTrail {
 public:
  /// `seconds` by any clock that does not run backward; the last half second is remembered.
  void add(double seconds, const Camera& camera);
  /// The last camera, moved on along the parabola through the first, the middle and the last place that is remembered
  /// (Schneider and Westermann 2006, section 6: a spline through its past); it looks the same way. The parabola bends
  /// away from the straight way no farther than that goes, so that a trembling hand does not throw it far. A single
  /// place, or a jump of the clock, leaves the camera where it is.
  Camera ahead(double seconds) const;

 private:
  struct Place {
    double seconds = 0;
    glm::dvec3 eye{0};
  };
  std::deque<Place> places_;
  Camera last_;
};

/// Tiles that an eye where `ahead` is would want in whichever direction it looks, and that are missing: of every level
/// those near enough that the error or the texels of the level above them could be larger than `options` allow
/// somewhere in some picture from there (Wahl et al. 2004, section 5, Caching & Prefetching), and likewise the finer
/// textures on the leaves among them (render/texture_parts.h), below those that are resident. Those with the largest
/// need, by the projected error or texels of what is round them, first; at most `most`. Pure. Cost: about 0.1 us a node
/// visited.
std::vector<cache::TileRef> prefetch(Trees trees, const Camera& ahead, const CutOptions& options,
                                     const TileStates& states, const TextureStates& textures, std::size_t most);

}  // namespace tintree::render
