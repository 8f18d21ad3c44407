#include "render/morph.h"

#include <algorithm>
#include <bit>

namespace tintree::render {

const cache::TileNode& parent_of(const cache::TileBounds& bounds, const cache::TileNode& node) {
  return bounds.nodes()[static_cast<std::size_t>(bounds.find(bounds.layout().parent(node.id)))];
}

double morph_weight(const cache::TileBounds& bounds, std::uint32_t node, const ScreenError& screen_error,
                    double pixel_error) {
  if (bounds.nodes()[node].id.level == 0) return 0;
  const cache::TileNode& parent = parent_of(bounds, bounds.nodes()[node]);
  const auto siblings = bounds.nodes().subspan(parent.first_child, std::popcount(unsigned{parent.child_mask}));
  const auto fine = static_cast<double>(std::ranges::max(siblings, {}, &cache::TileNode::lod_error_m).lod_error_m);
  const auto coarse = static_cast<double>(parent.lod_error_m);
  const auto coarse_px = screen_error.bound_px(bounds.box(parent), coarse);
  if (!coarse_px || *coarse_px <= pixel_error) return 1;
  const double allowed = pixel_error * coarse / *coarse_px;
  if (coarse <= fine) return 0;
  return std::clamp((allowed - fine) / (coarse - fine), 0.0, 1.0);
}

double farthest_morph_m(const cache::TileBounds& bounds, const cache::TileNode& node) {
  if (node.id.level == 0) return 0;
  return static_cast<double>(node.lod_error_m) + static_cast<double>(parent_of(bounds, node).lod_error_m);
}

cache::Box morph_box(const cache::TileBounds& bounds, const cache::TileNode& node) {
  cache::Box box = bounds.box(node);
  if (node.id.level == 0) return box;
  const cache::TileNode& parent = parent_of(bounds, node);
  const double room_m = farthest_morph_m(bounds, node);
  box.min[2] = std::max(box.min[2] - room_m, static_cast<double>(parent.z_min_m));
  box.max[2] = std::min(box.max[2] + room_m, static_cast<double>(parent.z_max_m));
  return box;
}

}  // namespace tintree::render
