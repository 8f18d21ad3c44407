#include "render/morph.h"

#include <algorithm>
#include <bit>

namespace tintree::render {

double morph_weight(const cache::TileBounds& bounds, std::uint32_t node, const Camera& camera, const Frustum& frustum,
                    double pixel_error) {
  const codec::TileId& id = bounds.nodes()[node].id;
  if (id.level == 0) return 0;
  const std::int64_t at = bounds.find(id.parent());
  if (at < 0) return 0;
  const cache::TileNode& parent = bounds.nodes()[static_cast<std::size_t>(at)];
  const auto siblings = bounds.nodes().subspan(parent.first_child, std::popcount(unsigned{parent.child_mask}));
  const auto fine = static_cast<double>(std::ranges::max(siblings, {}, &cache::TileNode::lod_error_m).lod_error_m);
  const auto coarse = static_cast<double>(parent.lod_error_m);
  const double allowed =
      pixel_error * frustum.nearest_depth_m(bounds.box(parent)) / (camera.focal_px() * camera.vertical_gain());
  if (coarse <= fine) return allowed >= coarse ? 1 : 0;
  return std::clamp((allowed - fine) / (coarse - fine), 0.0, 1.0);
}

double farthest_morph_m(const cache::TileBounds& bounds, const cache::TileNode& node) {
  if (node.id.level == 0) return 0;
  const cache::TileNode& parent = bounds.nodes()[static_cast<std::size_t>(bounds.find(node.id.parent()))];
  return static_cast<double>(node.lod_error_m) + static_cast<double>(parent.lod_error_m);
}

cache::Box morph_box(const cache::TileBounds& bounds, const cache::TileNode& node) {
  cache::Box box = bounds.box(node);
  const double room_m = farthest_morph_m(bounds, node);
  box.min[2] -= room_m;
  box.max[2] += room_m;
  return box;
}

}  // namespace tintree::render
