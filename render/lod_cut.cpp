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
#include "render/occlusion.h"

namespace tintree::render {
namespace {

/// Levels below a node whose boxes are asked whether they hide with it.
constexpr int kLookBelow = 2;

class Walk {
 public:
  Walk(Trees trees, const Camera& camera, const CutOptions& options, const TileStates& states,
       const OccluderOf& occluder_of)
      : trees_(trees),
        camera_(camera),
        frustum_(camera),
        options_(options),
        states_(states),
        occluder_of_(occluder_of) {}

  LodCut run() {
    for (const std::uint32_t tree : nearest_first()) {
      tree_ = tree;
      bounds_ = trees_[tree];
      begin_horizon();
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

  void begin_horizon() {
    horizon_ = occluder_of_ ? Horizon(camera_) : Horizon();
    const auto [column, row] = bounds_->layout().grid(camera_.eye.x, camera_.eye.y);
    eye_column_ = column;
    eye_row_ = row;
    if (!holds_eye(bounds_->layout().cells({}))) horizon_.place_eye(false);
  }

  /// The most that a tile's surface and its parent's can be apart.
  double farthest_morph_m(const cache::TileNode& node) const {
    if (!options_.morph || node.id.level == 0) return 0;
    return static_cast<double>(node.lod_error_m) + static_cast<double>(parent_of(node).lod_error_m);
  }
  const cache::TileNode& parent_of(const cache::TileNode& node) const {
    return bounds_->nodes()[static_cast<std::size_t>(bounds_->find(node.id.parent()))];
  }

  /// The box of all that may be drawn of a node.
  cache::Box box_of(const cache::TileNode& node) const {
    cache::Box box = bounds_->box(node);
    // Tiles below it move less.
    const double room_m = farthest_morph_m(node);
    box.min[2] -= room_m;
    box.max[2] += room_m;
    return box;
  }

  Seen look(const cache::TileNode& node) {
    const cache::Box box = box_of(node);
    if (frustum_.outside(box)) {
      ++cut_.culled;
      if (holds_eye(node)) horizon_.place_eye(camera_.eye.z > box.max[2]);
      return {true, 0, 0, 0, 0};
    }
    if (horizon_.usable() && horizon_.placed() && hidden(node, box, 0, kLookBelow)) {
      ++cut_.occluded;
      return {true, 0, 0, 0, 0};
    }
    // Levels are chosen by the boxes as they are, so that they are the same with morphs.
    const cache::Box still = bounds_->box(node);
    const double nearest_m = frustum_.nearest_depth_m(still);
    return {false, nearest_m, frustum_.farthest_depth_m(still),
            projected_error_px(static_cast<double>(node.lod_error_m), nearest_m, camera_),
            nearest_m > 0 ? bounds_->texel_m(node.id.level) * camera_.focal_px() / nearest_m
                          : std::numeric_limits<double>::infinity()};
  }

  bool is_fine_enough(const cache::TileNode& node, const Seen& seen) const {
    const bool sharp = bounds_->texel_m(node.id.level) == 0 || seen.texel_px <= options_.texel_px;
    return seen.error_px <= options_.pixel_error && sharp;
  }

  /// A node is hidden with its box, or with the boxes of those below it, which fit closer: its tile, and any
  /// between, leaves them by no more than its error and theirs.
  bool hidden(const cache::TileNode& node, const cache::Box& box, double error_m, int look_below) const {
    if (horizon_.hides(box)) return true;
    if (look_below == 0 || has_hole(node) || node.child_mask == 0) return false;
    const auto children = bounds_->nodes().subspan(node.first_child, std::popcount(unsigned{node.child_mask}));
    error_m = std::max(error_m, static_cast<double>(node.lod_error_m));
    return std::ranges::all_of(children, [&](const cache::TileNode& child) {
      cache::Box inner = box_of(child);
      inner.max[2] = std::min(inner.max[2] + error_m + static_cast<double>(child.lod_error_m), box.max[2]);
      return hidden(child, inner, error_m, look_below - 1);
    });
  }

  /// Whether a quadrant of the raster has no tile below this node.
  bool has_hole(const cache::TileNode& node) const {
    return std::ranges::any_of(std::array{0, 1, 2, 3}, [&](int q) { return is_hole(node, q); });
  }
  bool is_hole(const cache::TileNode& node, int quadrant) const {
    return (node.child_mask >> quadrant & 1) == 0 && !bounds_->layout().cells(node.id.child(quadrant)).empty();
  }

  bool holds_eye(const codec::CellRect& c) const {
    return eye_column_ >= static_cast<double>(c.column0) && eye_column_ <= static_cast<double>(c.column1) &&
           eye_row_ >= static_cast<double>(c.row0) && eye_row_ <= static_cast<double>(c.row1);
  }
  bool holds_eye(const cache::TileNode& node) const { return holds_eye(bounds_->layout().cells(node.id)); }

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
    const Horizon horizon = horizon_;
    bool covered = true;
    const unsigned nearest = nearest_quadrant(node.id);
    // Of four quadrants round a point the eye's own is in front, the opposite one at the back.
    for (unsigned i = 0; i < 4; ++i) {
      const unsigned quadrant = nearest ^ i;
      const unsigned mask = node.child_mask;
      if ((mask >> quadrant & 1U) == 0) {
        if (horizon_.usable() && is_hole(node, static_cast<int>(quadrant)))
          pass_hole(node.id.child(static_cast<int>(quadrant)));
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
    const auto half = static_cast<double>(layout.cells_across(id.level + 1));
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
    // Where it leaves a hole for good, what comes behind hides nothing; where an ancestor stands in, this is taken
    // back.
    if (here == TileState::kLost) horizon_.place_eye(false);
    return here;
  }

  /// Whether the tile is lost and so is every ancestor that could stand in for it.
  bool is_forsaken(std::uint32_t index) {
    codec::TileId id = bounds_->nodes()[index].id;
    while (state(index) == TileState::kLost) {
      if (id.level == 0) return true;
      id = id.parent();
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
      out.morph = morph_weight(*bounds_, index, camera_, frustum_, options_.pixel_error);
      const double error_m =
          std::lerp(static_cast<double>(node.lod_error_m), static_cast<double>(parent_of(node).lod_error_m), out.morph);
      if (out.morph > 0) out.error_px = projected_error_px(error_m, seen.nearest_m, camera_);
    }
    cut_.draws.push_back(out);
    if (horizon_.usable()) hide_behind(index, out.morph);
  }

  void hide_behind(std::uint32_t index, double morph) {
    const double moved_m = morph * farthest_morph_m(bounds_->nodes()[index]);
    const codec::CellRect cells = bounds_->layout().cells(bounds_->nodes()[index].id);
    const cache::Occluder* occluder = occluder_of_(tree_, index);
    if (!horizon_.placed() && holds_eye(cells))
      horizon_.place_eye(occluder != nullptr && camera_.eye.z > occluder->top_m(eye_column_, eye_row_) + moved_m);
    if (occluder != nullptr) {
      horizon_.add(*occluder, bounds_->layout(), moved_m);
    } else {
      horizon_.open(cells, bounds_->layout());
    }
  }

  /// No tile covers these cells of the raster: views through them see what ground behind would hide.
  void pass_hole(const codec::TileId& id) {
    const codec::CellRect cells = bounds_->layout().cells(id);
    if (holds_eye(cells)) horizon_.place_eye(false);
    cache::Box box = bounds_->box({.id = id});
    box.min[2] = static_cast<double>(bounds_->nodes().front().z_min_m);
    box.max[2] = static_cast<double>(bounds_->nodes().front().z_max_m);
    if (!frustum_.outside(box)) horizon_.open(cells, bounds_->layout());
  }

  void summarise() {
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
  const CutOptions& options_;
  const TileStates& states_;
  const OccluderOf& occluder_of_;
  Horizon horizon_;  ///< Of the tree where the walk is.
  double eye_column_ = 0;
  double eye_row_ = 0;
  LodCut cut_;
  std::vector<Asked> asked_;
};

}  // namespace

double projected_error_px(double lod_error_m, double nearest_depth_m, const Camera& camera) {
  if (lod_error_m <= 0) return 0;
  if (nearest_depth_m <= 0) return std::numeric_limits<double>::infinity();
  return lod_error_m * camera.focal_px() * camera.vertical_gain() / nearest_depth_m;
}

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
