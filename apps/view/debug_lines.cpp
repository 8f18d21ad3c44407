#include "apps/view/debug_lines.h"

#include <glm/geometric.hpp>

namespace tintree::view {

std::vector<render::WorldLine> box_lines(render::Trees trees, const render::LodCut& cut) {
  constexpr glm::vec4 kBox{0.10F, 0.25F, 0.75F, 0.8F};
  constexpr glm::vec4 kStandIn{0.95F, 0.45F, 0.10F, 0.9F};
  std::vector<render::WorldLine> lines;
  lines.reserve(12 * cut.draws.size());
  for (const render::DrawTile& d : cut.draws)
    render::add_box(lines, trees[d.tree]->box(trees[d.tree]->nodes()[d.node]), d.stands_in ? kStandIn : kBox);
  return lines;
}

std::vector<render::WorldLine> view_lines(const render::Camera& frozen) {
  constexpr glm::vec4 kView{1.0F, 0.85F, 0.2F, 1.0F};
  std::vector<render::WorldLine> lines;
  render::add_view(lines, frozen, glm::length(frozen.target - frozen.eye), kView);
  return lines;
}

}  // namespace tintree::view
