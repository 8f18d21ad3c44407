#include "render/tree_horizon.h"

#include <algorithm>
#include <array>
#include <bit>

#include "render/morph.h"

namespace tintree::render {
namespace {

/// Levels below a node whose boxes are asked whether they hide with it.
constexpr int kLookBelow = 2;

}  // namespace

TreeHorizon::TreeHorizon(const cache::TileBounds& bounds, const Camera& camera, const Frustum& frustum, bool morph,
                         double off_px)
    : bounds_(&bounds), camera_(&camera), frustum_(&frustum), morph_(morph), horizon_(camera, off_px) {
  const auto [column, row] = bounds.layout().grid(camera.eye.x, camera.eye.y);
  eye_column_ = column;
  eye_row_ = row;
  if (!holds_eye(bounds.layout().cells({}))) horizon_.place_eye(false);
}

bool TreeHorizon::hides(const cache::TileNode& node) const {
  return horizon_.usable() && horizon_.placed() && hides(node, box_of(node), 0, kLookBelow);
}

// The tile, and any between, leaves the boxes below by no more than its error and theirs.
bool TreeHorizon::hides(const cache::TileNode& node, const cache::Box& box, double error_m, int look_below) const {
  if (horizon_.hides(box)) return true;
  if (look_below == 0 || node.child_mask == 0) return false;
  if (std::ranges::any_of(std::array{0, 1, 2, 3}, [&](int q) { return is_hole(node, q); })) return false;
  const auto children = bounds_->nodes().subspan(node.first_child, std::popcount(unsigned{node.child_mask}));
  error_m = std::max(error_m, static_cast<double>(node.lod_error_m));
  return std::ranges::all_of(children, [&](const cache::TileNode& child) {
    cache::Box inner = box_of(child);
    inner.max[2] = std::min(inner.max[2] + error_m + static_cast<double>(child.lod_error_m), box.max[2]);
    return hides(child, inner, error_m, look_below - 1);
  });
}

void TreeHorizon::pass_unseen(const cache::TileNode& node) {
  if (horizon_.usable() && holds_eye(bounds_->layout().cells(node.id)))
    horizon_.place_eye(camera_->eye.z > box_of(node).max[2]);
}

void TreeHorizon::pass_missing(const cache::TileNode& node, int quadrant) {
  if (!horizon_.usable() || !is_hole(node, quadrant)) return;
  const codec::TileId id = bounds_->layout().child(node.id, quadrant);
  const codec::CellRect cells = bounds_->layout().cells(id);
  if (holds_eye(cells)) horizon_.place_eye(false);
  cache::Box box = bounds_->box({.id = id});
  box.min[2] = static_cast<double>(bounds_->nodes().front().z_min_m);
  box.max[2] = static_cast<double>(bounds_->nodes().front().z_max_m);
  // Views through these cells see what ground behind would hide.
  if (!frustum_->outside(box)) horizon_.open(cells, bounds_->layout());
}

void TreeHorizon::add(const cache::TileNode& node, const cache::Occluder* occluder, double morph) {
  if (!horizon_.usable()) return;
  const double moved_m = morph * (morph_ ? farthest_morph_m(*bounds_, node) : 0);
  const codec::CellRect cells = bounds_->layout().cells(node.id);
  if (!horizon_.placed() && holds_eye(cells))
    horizon_.place_eye(occluder != nullptr && camera_->eye.z > occluder->top_m(eye_column_, eye_row_) + moved_m);
  if (occluder != nullptr) {
    horizon_.add(*occluder, bounds_->layout(), moved_m);
  } else {
    horizon_.open(cells, bounds_->layout());
  }
}

cache::Box TreeHorizon::box_of(const cache::TileNode& node) const {
  return morph_ ? morph_box(*bounds_, node) : bounds_->box(node);
}

bool TreeHorizon::holds_eye(const codec::CellRect& c) const {
  return eye_column_ >= static_cast<double>(c.column0) && eye_column_ <= static_cast<double>(c.column1) &&
         eye_row_ >= static_cast<double>(c.row0) && eye_row_ <= static_cast<double>(c.row1);
}

bool TreeHorizon::is_hole(const cache::TileNode& node, int quadrant) const {
  const codec::TreeLayout& layout = bounds_->layout();
  return quadrant < layout.child_count(node.id.level) && (node.child_mask >> quadrant & 1) == 0 &&
         !layout.cells(layout.child(node.id, quadrant)).empty();
}

}  // namespace tintree::render
