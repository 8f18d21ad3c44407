#include "render/nested_lod.h"

#include <algorithm>
#include <cmath>

namespace tintree::render {
namespace {

constexpr int kFinest = cache::NestedShape::kLevels - 1;

}  // namespace

float level_for(float bounds) {
  const float coarser = std::floor(std::max(std::log2(bounds), 0.0F));
  return kFinest + 1 - coarser - std::max(bounds, 1.0F) * std::exp2(-coarser);
}

int mesh_level(const ScreenError& screen_error, const cache::Box& box, double bound_m, double pixel_error) {
  int level = kFinest;
  while (level > 0) {
    const auto coarser_px = screen_error.bound_px(box, std::ldexp(bound_m, kFinest - level + 1));
    if (!coarser_px || *coarser_px > pixel_error) break;
    --level;
  }
  return level;
}

std::array<float, cache::NestedShape::kLevels> morph_weights(float level) {
  std::array<float, cache::NestedShape::kLevels> out{};
  float before = 1;
  for (int i = 0; i <= kFinest; ++i) {
    const float ramp = i < kFinest ? std::clamp(level - static_cast<float>(i), 0.0F, 1.0F) : 0;
    out[static_cast<std::size_t>(i)] = before - ramp;
    before = ramp;
  }
  return out;
}

void choose_nested_levels(Trees trees, const Camera& camera, std::span<const std::uint8_t> nested, LodCut& cut) {
  if (std::ranges::none_of(nested, [](std::uint8_t is) { return is != 0; })) return;
  const ScreenError screen_error(camera);
  for (DrawTile& d : cut.draws) {
    if (nested[d.tree] == 0) continue;
    const cache::TileBounds& bounds = *trees[d.tree];
    const cache::TileNode& node = bounds.nodes()[d.node];
    const double bound_m = bounds.layout().bound_m(node.id.level);
    d.nested_level = mesh_level(screen_error, bounds.box(node), bound_m, cut.options.pixel_error);
    const double error_m = std::ldexp(bound_m, kFinest - d.nested_level);
    if (d.nested_level < kFinest) d.error_px = screen_error.bound_px(bounds.box(node), error_m).value_or(d.error_px);
    cut.max_error_px = std::max(cut.max_error_px, d.error_px);
  }
}

}  // namespace tintree::render
