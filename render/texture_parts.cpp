#include "render/texture_parts.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include <glm/geometric.hpp>

#include "render/frustum.h"
#include "render/leaf_squares.h"

namespace tintree::render {
namespace {

class Division {
 public:
  Division(LodCut& cut, Trees trees, const Camera& camera, const TextureStates& states)
      : cut_(cut),
        trees_(trees),
        camera_(camera),
        frustum_(camera),
        allowed_m_(cut.options.texel_px / camera.focal_px()),
        states_(states) {}

  void run() {
    int row = 0;
    for (DrawTile& draw : cut_.draws) {
      divide(draw);
      if (draw.parts > 0) draw.part_row = row++;
    }
    std::ranges::sort(asked_, [](const Asked& a, const Asked& b) {
      return std::tuple(a.square.id.level, a.off_middle) < std::tuple(b.square.id.level, b.off_middle);
    });
    for (const Asked& a : asked_) cut_.requests.push_back(a.square);
  }

 private:
  struct Asked {
    cache::TileRef square;
    double off_middle = 0;  ///< Less the cosine of the angle between the view and the way to its box.
  };

  void divide(DrawTile& draw) {
    const cache::TileBounds& bounds = *trees_[draw.tree];
    const cache::TileNode& leaf = bounds.nodes()[draw.node];
    if (!LeafSquares::are_on(bounds, leaf)) return;
    const LeafSquares squares(bounds, leaf);
    draw.first_part = static_cast<std::uint32_t>(cut_.parts.size());
    visit(draw.tree, squares, {}, squares.box({}));
    draw.parts = static_cast<std::uint32_t>(cut_.parts.size()) - draw.first_part;
  }

  /// `box`: round the square, which is in view.
  void visit(std::uint32_t tree, const LeafSquares& squares, const LeafSquare& square, const cache::Box& box) {
    if (squares.is_finest(square) || squares.texel_m(square) <= allowed_m_ * frustum_.nearest_depth_m(box)) return;
    for (std::uint32_t q = 0; q < 4; ++q) look(tree, squares, square.quadrant(q));
  }

  void look(std::uint32_t tree, const LeafSquares& squares, const LeafSquare& square) {
    const cache::Box box = squares.box(square);
    if (squares.is_beyond(square) || frustum_.outside(box)) return;
    const cache::TileRef ref{squares.id(square), tree};
    switch (states_(ref)) {
      case TextureState::kNone:
        return;
      case TextureState::kMissing:
        ++cut_.wanted;
        ++cut_.late;
        cut_.complete = false;
        ask(ref, box);
        return;
      case TextureState::kLost:
        ++cut_.wanted;
        cut_.complete = false;
        break;
      case TextureState::kResident:
        ++cut_.wanted;
        cut_.parts.push_back({square.depth, square.x, square.y, ref.id});
        break;
    }
    visit(tree, squares, square, box);
  }

  void ask(const cache::TileRef& ref, const cache::Box& box) {
    const glm::dvec3 low(box.min[0], box.min[1], box.min[2]);
    const glm::dvec3 high(box.max[0], box.max[1], box.max[2]);
    const glm::dvec3 way = 0.5 * (low + high) - camera_.eye;
    asked_.push_back({ref, -glm::dot(way, forward_) / std::max(glm::length(way), 1e-9)});
  }

  LodCut& cut_;
  Trees trees_;
  const Camera& camera_;
  const glm::dvec3 forward_ = camera_.axes().forward;
  const Frustum frustum_;
  const double allowed_m_;  ///< Side of a texel, a metre of depth.
  const TextureStates& states_;
  std::vector<Asked> asked_;
};

}  // namespace

void add_texture_parts(LodCut& cut, Trees trees, const Camera& camera, const TextureStates& states) {
  if (std::ranges::all_of(trees, [](const cache::TileBounds* tree) { return tree->texture_depth() == 0; })) return;
  Division(cut, trees, camera, states).run();
}

}  // namespace tintree::render
