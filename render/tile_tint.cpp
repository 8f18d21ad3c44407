#include "render/tile_tint.h"

#include <algorithm>
#include <array>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace tintree::render {
namespace {

constexpr float kStrength = 0.85F;

glm::vec3 level_color(int level) {
  static constexpr std::array<std::array<float, 3>, 7> kHues{{{0.55F, 0.35F, 0.75F},
                                                              {0.25F, 0.45F, 0.85F},
                                                              {0.20F, 0.70F, 0.75F},
                                                              {0.35F, 0.72F, 0.35F},
                                                              {0.90F, 0.82F, 0.30F},
                                                              {0.93F, 0.55F, 0.25F},
                                                              {0.85F, 0.30F, 0.30F}}};
  const auto& hue = kHues[static_cast<std::size_t>(level) % kHues.size()];
  return {hue[0], hue[1], hue[2]};
}

glm::vec3 error_color(double share) {
  const glm::vec3 none(0.20F, 0.35F, 0.80F);
  const glm::vec3 half(0.30F, 0.72F, 0.40F);
  const glm::vec3 all(0.95F, 0.85F, 0.30F);
  const glm::vec3 more(0.85F, 0.22F, 0.20F);
  if (share > 1) return more;
  const auto t = static_cast<float>(2 * share);
  return t < 1 ? glm::mix(none, half, t) : glm::mix(half, all, t - 1);
}

}  // namespace

glm::vec4 tile_tint(Tint tint, const cache::TileNode& node, const DrawTile& drawn, double allowed_px) {
  switch (tint) {
    case Tint::kHeight:
      break;
    case Tint::kLevel:
      return {level_color(node.id.level), kStrength};
    case Tint::kError:
      return {error_color(drawn.error_px / std::max(allowed_px, 1e-9)), kStrength};
  }
  return glm::vec4(0);
}

}  // namespace tintree::render
