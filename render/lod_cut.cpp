#include "render/lod_cut.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>

#include "render/frustum.h"
#include "render/morph.h"
#include "render/screen_error.h"
#include "render/tree_horizon.h"

namespace tintree::render {
namespace {

class Walk {
 public:
  Walk(Trees trees, const Camera& camera, const CutOptions& options, const TileStates& states,
       const OccluderOf& occluder_of)
      : trees_(trees),
        camera_(camera),
        frustum_(camera),
        screen_error_(camera),
        options_(options),
        states_(states),
        occluder_of_(occluder_of) {}

  LodCut run() {
    for (const std::uint32_t tree : nearest_first()) {
      tree_ = tree;
      bounds_ = trees_[tree];
      horizon_ =
          occluder_of_ ? TreeHorizon(*bounds_, camera_, frustum_, options_.morph, options_.off_px) : TreeHorizon();
      visit(0);
    }
    order_requests();
    summarise();
    return std::move(cut_);
  }

 private:
  struct Seen {
    bool unseen = false;  ///< Outside the frustum, or hidden.
    double nearest_m = 0;
    double farthest_m = 0;
    double error_px = 0;
    double texel_px = 0;
  };

  Seen look(const cache::TileNode& node) {
    if (frustum_.outside(options_.morph ? morph_box(*bounds_, node) : bounds_->box(node))) return pass_unseen(node);
    if (horizon_.hides(node)) {
      ++cut_.occluded;
      return {true, 0, 0, 0, 0};
    }
    // Levels are chosen by the boxes as they are, so that they are the same with morphs.
    const cache::Box still = bounds_->box(node);
    const auto error_px = screen_error_.bound_px(still, static_cast<double>(node.lod_error_m));
    if (!error_px && !options_.morph) return pass_unseen(node);
    const double nearest_m = frustum_.nearest_depth_m(still);
    return {false, nearest_m, frustum_.farthest_depth_m(still), error_px.value_or(0),
            nearest_m > 0 ? bounds_->texel_m(node.id.level) * camera_.focal_px() / nearest_m
                          : std::numeric_limits<double>::infinity()};
  }

  Seen pass_unseen(const cache::TileNode& node) {
    ++cut_.culled;
    horizon_.pass_unseen(node);
    return {true, 0, 0, 0, 0};
  }

  bool is_fine_enough(const cache::TileNode& node, const Seen& seen) const {
    const bool sharp = bounds_->texel_m(node.id.level) == 0 || seen.texel_px <= options_.texel_px ||
                       bounds_->layout().is_leaf_square(node.id.level);  // There are none finer.
    return seen.error_px <= options_.pixel_error && sharp;
  }

  struct Asked {
    cache::TileRef tile;
    double off_middle = 0;  ///< Less the cosine of the angle between the view and the way to its box.
  };

  /// Draws all that is visible under a node; false when it cannot, and then has drawn nothing of it.
  bool visit(std::uint32_t index) {
    const cache::TileNode& node = bounds_->nodes()[index];
    const Seen seen = look(node);
    if (seen.unseen) return true;
    const bool leaf = node.child_mask == 0;
    if (leaf || is_fine_enough(node, seen)) return take(index, seen);
    if (visit_children(index, [this](std::uint32_t child) { return visit(child); })) return true;
    const TileState here = state(index);
    if (here != TileState::kResident) {
      if (here == TileState::kMissing) ask(node);
      return false;
    }
    draw(index, seen, true);
    return true;
  }

  bool take(std::uint32_t index, const Seen& seen) {
    ++cut_.wanted;
    const TileState here = state(index);
    if (here == TileState::kResident) {
      if (seen.error_px > options_.pixel_error) ++cut_.leaf_limited;
      draw(index, seen, false);
      return true;
    }
    cut_.complete = false;
    if (is_forsaken(index)) return visit_children(index, [this](std::uint32_t child) { return visit(child); });
    if (here == TileState::kMissing) {
      ++cut_.late;
      ask(bounds_->nodes()[index]);
    }
    return visit_children(index, [this](std::uint32_t child) { return stand_in_finer(child); });
  }

  /// Covers a node by itself or by finer tiles, asking for nothing.
  bool stand_in_finer(std::uint32_t index) {
    const Seen seen = look(bounds_->nodes()[index]);
    if (seen.unseen) return true;
    if (state(index) != TileState::kResident)
      return visit_children(index, [this](std::uint32_t child) { return stand_in_finer(child); });
    draw(index, seen, true);
    return true;
  }

  /// Visits the children front to back; when one cannot be drawn, takes back what the others drew. Goes on
  /// all the same, for their requests. False for a node without children. A forsaken node counts as covered by what
  /// there is.
  template <typename Visit>
  bool visit_children(std::uint32_t index, const Visit& visit_child) {
    const cache::TileNode& node = bounds_->nodes()[index];
    if (node.child_mask == 0) return is_forsaken(index);
    const std::size_t drawn = cut_.draws.size();
    const std::uint32_t leaf_limited = cut_.leaf_limited;
    const std::uint32_t occluded = cut_.occluded;
    const TreeHorizon horizon = horizon_;
    bool covered = true;
    const unsigned nearest = nearest_quadrant(node.id);
    // Of four quadrants round a point the eye's own is in front, the opposite one at the back.
    for (unsigned i = 0; i < 4; ++i) {
      const unsigned quadrant = nearest ^ i;
      const unsigned mask = node.child_mask;
      if ((mask >> quadrant & 1U) == 0) {
        horizon_.pass_missing(node, static_cast<int>(quadrant));
        continue;
      }
      const auto before = static_cast<std::uint32_t>(std::popcount(mask & ((1U << quadrant) - 1)));
      covered = visit_child(node.first_child + before) && covered;
    }
    if (covered || is_forsaken(index)) return true;
    cut_.draws.resize(drawn);
    cut_.leaf_limited = leaf_limited;
    cut_.occluded = occluded;
    horizon_ = horizon;
    return false;
  }

  unsigned nearest_quadrant(const codec::TileId& id) const {
    const codec::TreeLayout& layout = bounds_->layout();
    const auto half = 0.5 * static_cast<double>(layout.cells_across(id.level));
    const auto [column, row] = layout.grid(camera_.eye.x, camera_.eye.y);
    return (column >= (2.0 * id.x + 1) * half ? 1U : 0U) | (row > (2.0 * id.y + 1) * half ? 2U : 0U);
  }

  void ask(const cache::TileNode& node) {
    const cache::Box box = bounds_->box(node);
    const glm::dvec3 middle(box.min[0] + box.max[0], box.min[1] + box.max[1], box.min[2] + box.max[2]);
    const glm::dvec3 way = 0.5 * middle - camera_.eye;
    asked_.push_back({{node.id, tree_}, -glm::dot(way, forward_) / std::max(glm::length(way), 1e-9)});
  }

  void order_requests() {
    std::ranges::stable_sort(asked_, [](const Asked& a, const Asked& b) {
      return std::pair(a.tile.id.level, a.off_middle) < std::pair(b.tile.id.level, b.off_middle);
    });
    for (const Asked& a : asked_) cut_.requests.push_back(a.tile);
  }

  TileState state(std::uint32_t index) {
    const TileState here = states_(tree_, index);
    if (here == TileState::kLost) horizon_.pass_lost();
    return here;
  }

  /// Whether the tile is lost and so is every ancestor that could stand in for it.
  bool is_forsaken(std::uint32_t index) {
    codec::TileId id = bounds_->nodes()[index].id;
    while (state(index) == TileState::kLost) {
      if (id.level == 0) return true;
      id = bounds_->layout().parent(id);
      index = static_cast<std::uint32_t>(bounds_->find(id));
    }
    return false;
  }

  /// The trees that have tiles, by the distance of their boxes.
  std::vector<std::uint32_t> nearest_first() const {
    std::vector<std::pair<double, std::uint32_t>> order;
    for (std::uint32_t i = 0; i < trees_.size(); ++i) {
      if (trees_[i]->nodes().empty()) continue;
      order.emplace_back(frustum_.nearest_depth_m(trees_[i]->box(trees_[i]->nodes().front())), i);
    }
    std::ranges::sort(order);
    std::vector<std::uint32_t> out;
    for (const auto& [depth_m, i] : order) out.push_back(i);
    return out;
  }

  void draw(std::uint32_t index, const Seen& seen, bool stands_in) {
    DrawTile out{tree_, index, seen.error_px, seen.nearest_m, seen.farthest_m, stands_in};
    const cache::TileNode& node = bounds_->nodes()[index];
    if (options_.morph && node.id.level > 0) {
      out.morph = morph_weight(*bounds_, index, screen_error_, options_.pixel_error);
      const double error_m = std::lerp(static_cast<double>(node.lod_error_m),
                                       static_cast<double>(parent_of(*bounds_, node).lod_error_m), out.morph);
      if (out.morph > 0) out.error_px = screen_error_.bound_px(morph_box(*bounds_, node), error_m).value_or(0);
    }
    cut_.draws.push_back(out);
    if (occluder_of_) horizon_.add(node, occluder_of_(tree_, index), out.morph);
  }

  void summarise() {
    cut_.options = options_;
    if (!cut_.draws.empty()) cut_.nearest_m = std::numeric_limits<double>::infinity();
    for (const DrawTile& d : cut_.draws) {
      cut_.max_error_px = std::max(cut_.max_error_px, d.error_px);
      cut_.nearest_m = std::min(cut_.nearest_m, d.nearest_m);
      cut_.farthest_m = std::max(cut_.farthest_m, d.farthest_m);
      if (d.stands_in) cut_.complete = false;
    }
  }

  Trees trees_;
  std::uint32_t tree_ = 0;  ///< Where the walk is,
  const cache::TileBounds* bounds_ = nullptr;
  const Camera& camera_;
  const glm::dvec3 forward_ = camera_.axes().forward;
  const Frustum frustum_;
  const ScreenError screen_error_;
  const CutOptions& options_;
  const TileStates& states_;
  const OccluderOf& occluder_of_;
  TreeHorizon horizon_;  ///< Of the tree where the walk is.
  LodCut cut_;
  std::vector<Asked> asked_;
};

}  // namespace

LodCut lod_cut(Trees trees, const Camera& camera, const CutOptions& options, const TileStates& states,
               const OccluderOf& occluder_of) {
  return Walk(trees, camera, options, states, occluder_of).run();
}

LodCut lod_cut(const cache::TileBounds& bounds, const Camera& camera, const CutOptions& options,
               const IsResident& resident, const OccluderOf& occluder_of) {
  const std::array<const cache::TileBounds*, 1> one{&bounds};
  return lod_cut(
      one, camera, options,
      [&resident](std::uint32_t, std::uint32_t node) {
        return resident(node) ? TileState::kResident : TileState::kMissing;
      },
      occluder_of);
}

}  // namespace tintree::render
