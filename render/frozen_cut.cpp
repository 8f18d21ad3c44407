#include "render/frozen_cut.h"

#include <algorithm>
#include <limits>

#include "render/frustum.h"

namespace tintree::render {

LodCut seen_from(LodCut cut, Trees trees, const Camera& camera) {
  const Frustum frustum(camera);
  cut.nearest_m = std::numeric_limits<double>::infinity();
  cut.farthest_m = 0;
  for (DrawTile& d : cut.draws) {
    const cache::Box box = trees[d.tree]->box(trees[d.tree]->nodes()[d.node]);
    d.nearest_m = std::max(0.0, frustum.nearest_depth_m(box));
    d.farthest_m = frustum.farthest_depth_m(box);
    if (frustum.outside(box)) continue;
    cut.nearest_m = std::min(cut.nearest_m, d.nearest_m);
    cut.farthest_m = std::max(cut.farthest_m, d.farthest_m);
  }
  if (cut.farthest_m == 0) cut.nearest_m = 0;
  return cut;
}

}  // namespace tintree::render
