#include "render/prefetch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "render/frustum.h"

namespace tintree::render {
namespace {

constexpr double kRemembered_s = 0.5;

double distance_m(const cache::Box& box, const glm::dvec3& eye) {
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    const double off = std::max({box.min[axis] - eye[i], eye[i] - box.max[axis], 0.0});
    squared += off * off;
  }
  return std::sqrt(squared);
}

class SphereWalk {
 public:
  SphereWalk(Trees trees, const Camera& camera, const CutOptions& options, const TileStates& states)
      : trees_(trees), camera_(camera), options_(options), states_(states) {
    corner_cosine_ = 1 / std::hypot(1.0, camera.tan_half_x(), camera.tan_half_y());
  }

  std::vector<cache::TileRef> run(std::size_t most) {
    for (std::uint32_t tree = 0; tree < trees_.size(); ++tree) {
      if (!trees_[tree]->nodes().empty()) visit(tree, 0, std::numeric_limits<double>::infinity());
    }
    std::ranges::stable_sort(found_, std::ranges::greater(), &Found::need_px);
    if (found_.size() > most) found_.resize(most);
    std::vector<cache::TileRef> out;
    for (const Found& f : found_) out.push_back(f.tile);
    return out;
  }

 private:
  struct Found {
    cache::TileRef tile;
    double need_px = 0;
  };

  void visit(std::uint32_t tree, std::uint32_t index, double need_px) {
    const cache::TileBounds& bounds = *trees_[tree];
    const cache::TileNode& node = bounds.nodes()[index];
    // The least depth that a point at this distance can have in a picture.
    const double depth_m = distance_m(bounds.box(node), camera_.eye) * corner_cosine_;
    const double error_px = projected_error_px(static_cast<double>(node.lod_error_m), depth_m, camera_);
    if (node.child_mask == 0 || error_px <= options_.pixel_error) {
      if (states_(tree, index) == TileState::kMissing) found_.push_back({{node.id, tree}, need_px});
      return;
    }
    for (int i = 0; i < std::popcount(node.child_mask); ++i) {
      visit(tree, node.first_child + static_cast<std::uint32_t>(i), error_px);
    }
  }

  Trees trees_;
  const Camera& camera_;
  const CutOptions& options_;
  const TileStates& states_;
  double corner_cosine_ = 1;
  std::vector<Found> found_;
};

}  // namespace

void CameraTrail::add(double seconds, const Camera& camera) {
  if (!places_.empty() && (seconds < places_.back().seconds || seconds > places_.back().seconds + kRemembered_s))
    places_.clear();
  places_.push_back({seconds, camera.eye});
  while (places_.front().seconds < seconds - kRemembered_s) places_.pop_front();
  last_ = camera;
}

Camera CameraTrail::ahead(double seconds) const {
  Camera out = last_;
  if (places_.size() < 2 || !(places_.back().seconds > places_.front().seconds)) return out;
  const glm::dvec3 velocity =
      (places_.back().eye - places_.front().eye) / (places_.back().seconds - places_.front().seconds);
  out.eye += velocity * seconds;
  out.target += velocity * seconds;
  return out;
}

std::vector<cache::TileRef> prefetch(Trees trees, const Camera& ahead, const CutOptions& options,
                                     const TileStates& states, std::size_t most) {
  return SphereWalk(trees, ahead, options, states).run(most);
}

}  // namespace tintree::render
