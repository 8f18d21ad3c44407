#include "render/texture_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include <glm/geometric.hpp>

#include "render/frustum.h"

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
  /// A square in the leaf: which, of a grid with `1 << depth` squares a side.
  struct Square {
    int depth = 0;
    std::uint32_t x = 0;
    std::uint32_t y = 0;
  };
  struct Asked {
    cache::TileRef square;
    double off_middle = 0;  ///< Less the cosine of the angle between the view and the way to its box.
  };

  void divide(DrawTile& draw) {
    bounds_ = trees_[draw.tree];
    tree_ = draw.tree;
    leaf_ = &bounds_->nodes()[draw.node];
    if (bounds_->texture_depth() == 0 || !bounds_->layout().is_leaf_square(leaf_->id.level)) return;
    leaf_box_ = bounds_->box(*leaf_);
    draw.first_part = static_cast<std::uint32_t>(cut_.parts.size());
    visit({}, leaf_box_);
    draw.parts = static_cast<std::uint32_t>(cut_.parts.size()) - draw.first_part;
  }

  /// `box`: round the square, which is in view.
  void visit(const Square& square, const cache::Box& box) {
    const double texel_m = std::ldexp(bounds_->texel_m(leaf_->id.level), -square.depth);
    if (square.depth == bounds_->texture_depth() || texel_m <= allowed_m_ * frustum_.nearest_depth_m(box)) return;
    for (std::uint32_t q = 0; q < 4; ++q) look({square.depth + 1, 2 * square.x + (q & 1U), 2 * square.y + (q >> 1U)});
  }

  void look(const Square& square) {
    const cache::Box box = box_of(square);
    if (is_beyond(square) || frustum_.outside(box)) return;
    const codec::TileId id = id_of(square);
    switch (states_({id, tree_})) {
      case TextureState::kNone:
        return;
      case TextureState::kMissing:
        ++cut_.wanted;
        ++cut_.late;
        cut_.complete = false;
        ask(id, box);
        return;
      case TextureState::kLost:
        ++cut_.wanted;
        cut_.complete = false;
        break;
      case TextureState::kResident:
        ++cut_.wanted;
        cut_.parts.push_back({square.depth, square.x, square.y, id});
        break;
    }
    visit(square, box);
  }

  void ask(const codec::TileId& id, const cache::Box& box) {
    const glm::dvec3 low(box.min[0], box.min[1], box.min[2]);
    const glm::dvec3 high(box.max[0], box.max[1], box.max[2]);
    const glm::dvec3 way = 0.5 * (low + high) - camera_.eye;
    asked_.push_back({{id, tree_}, -glm::dot(way, forward_) / std::max(glm::length(way), 1e-9)});
  }

  /// The place of a square among all of its size.
  std::uint32_t column(const Square& s) const { return (leaf_->id.x << s.depth) + s.x; }
  std::uint32_t row(const Square& s) const { return (leaf_->id.y << s.depth) + s.y; }
  double cells_across(const Square& s) const {
    return std::ldexp(static_cast<double>(bounds_->layout().tile_cells), -s.depth);
  }

  /// As Manifest::picture_layout() names it.
  codec::TileId id_of(const Square& s) const {
    const codec::TreeLayout& layout = bounds_->layout();
    return {layout.coarsest_level(layout.halvings(leaf_->id.level) + s.depth), column(s), row(s)};
  }

  bool is_beyond(const Square& s) const {
    const codec::TreeLayout& layout = bounds_->layout();
    return column(s) * cells_across(s) >= static_cast<double>(layout.columns - 1) ||
           row(s) * cells_across(s) >= static_cast<double>(layout.rows - 1);
  }

  cache::Box box_of(const Square& s) const {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    const double cells = cells_across(s);
    cache::Box box{{kFar, kFar, leaf_box_.min[2]}, {-kFar, -kFar, leaf_box_.max[2]}};
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      const auto at = bounds_->layout().world((column(s) + (corner & 1U)) * cells, (row(s) + (corner >> 1U)) * cells);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        box.min[axis] = std::min(box.min[axis], at[axis]);
        box.max[axis] = std::max(box.max[axis], at[axis]);
      }
    }
    return box;
  }

  LodCut& cut_;
  Trees trees_;
  const Camera& camera_;
  const glm::dvec3 forward_ = camera_.axes().forward;
  const Frustum frustum_;
  const double allowed_m_;  ///< Side of a texel, a metre of depth.
  const TextureStates& states_;
  const cache::TileBounds* bounds_ = nullptr;  ///< Of the tile that is looked at,
  std::uint32_t tree_ = 0;
  const cache::TileNode* leaf_ = nullptr;  ///< which is this,
  cache::Box leaf_box_;                    ///< and lies here.
  std::vector<Asked> asked_;
};

}  // namespace

void add_texture_parts(LodCut& cut, Trees trees, const Camera& camera, const TextureStates& states) {
  if (std::ranges::all_of(trees, [](const cache::TileBounds* tree) { return tree->texture_depth() == 0; })) return;
  Division(cut, trees, camera, states).run();
}

}  // namespace tintree::render
