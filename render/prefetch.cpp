#include "render/prefetch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "render/impostor.h"
#include "render/leaf_squares.h"
#include "render/screen_error.h"

namespace tintree::render {
namespace {

constexpr double kRemembered_s = 0.5;

/// The range of distances between two numbers from a third.
std::array<double, 2> distances(double low, double high, double from) {
  return {std::max({low - from, from - high, 0.0}), std::max(std::abs(low - from), std::abs(high - from))};
}

/// Camera::vertical_gain() at the elevation where it is largest. With c and s the elevation's cosine and sine its
/// square is (tan_half_x s)² + (c + tan_half_y s)², a quadratic form; this is its larger eigenvalue's root.
double most_vertical_gain(const Camera& camera) {
  const double sides = std::pow(camera.tan_half_x(), 2) + std::pow(camera.tan_half_y(), 2);
  return std::sqrt(0.5 * (1 + sides) + std::hypot(0.5 * (1 - sides), camera.tan_half_y()));
}

class SphereWalk {
 public:
  SphereWalk(Trees trees, const Camera& camera, const CutOptions& options, const TileStates& states,
             const TextureStates& textures)
      : trees_(trees), camera_(camera), options_(options), states_(states), textures_(textures) {
    corner_cosine_ = 1 / std::hypot(1.0, camera.tan_half_x(), camera.tan_half_y());
    most_gain_ = most_vertical_gain(camera);
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
    const cache::Box box = bounds.box(node);
    const double error_px = most_error_px(box, static_cast<double>(node.lod_error_m));
    const bool on_leaf = bounds.layout().is_leaf_square(node.id.level);
    const double texel_px = on_leaf ? 0 : most_texel_px(box, bounds.texel_m(node.id.level));
    if (node.child_mask == 0 || (error_px <= options_.pixel_error && texel_px <= options_.texel_px)) {
      if (states_(tree, index) == TileState::kMissing) found_.push_back({{node.id, tree}, need_px});
      if (LeafSquares::are_on(bounds, node)) visit(tree, LeafSquares(bounds, node), {});
      return;
    }
    for (int i = 0; i < std::popcount(node.child_mask); ++i) {
      visit(tree, node.first_child + static_cast<std::uint32_t>(i), std::max(error_px, texel_px));
    }
  }

  /// What lies on the quadrants of a square that has a texture.
  void visit(std::uint32_t tree, const LeafSquares& squares, const LeafSquare& square) {
    if (squares.is_finest(square)) return;
    const double texel_px = most_texel_px(squares.box(square), squares.texel_m(square));
    if (texel_px <= options_.texel_px) return;
    for (std::uint32_t q = 0; q < 4; ++q) {
      const LeafSquare quadrant = square.quadrant(q);
      if (squares.is_beyond(quadrant)) continue;
      const cache::TileRef ref{squares.id(quadrant), tree};
      const TextureState state = textures_(ref);
      if (state == TextureState::kMissing) found_.push_back({ref, texel_px});
      if (state == TextureState::kResident || state == TextureState::kLost) visit(tree, squares, quadrant);
    }
  }

  /// What the side of a texel in a box takes at most, whichever way the camera looks.
  double most_texel_px(const cache::Box& box, double texel_m) const {
    return texel_m > 0 ? texel_m * camera_.focal_px() / (nearest_m(box, camera_.eye) * corner_cosine_) : 0;
  }

  /// ScreenError::bound_px() whichever way the camera looks. A point at distance d, r of it level, is seen at depth
  /// Z >= d cosine, and its g / Z is |ahead x (up x way)| / Z² <= r / Z².
  double most_error_px(cache::Box box, double error_m) const {
    if (error_m <= 0) return 0;
    box.min[2] -= error_m;
    box.max[2] += error_m;
    const auto x = distances(box.min[0], box.max[0], camera_.eye.x);
    const auto y = distances(box.min[1], box.max[1], camera_.eye.y);
    const double height = distances(box.min[2], box.max[2], camera_.eye.z)[0];
    const double depth = std::hypot(x[0], y[0], height) * corner_cosine_;
    if (depth <= error_m) return std::numeric_limits<double>::infinity();
    // r / (r² + height²) is largest where r is the height.
    const double level = std::clamp(height, std::hypot(x[0], y[0]), std::hypot(x[1], y[1]));
    const double slant = level / (std::pow(level, 2) + std::pow(height, 2)) / std::pow(corner_cosine_, 2);
    const double gain = std::max(std::min(slant, most_gain_ / depth), ScreenError::kLeastGain / depth);
    return camera_.focal_px() * error_m * gain / (1 - error_m / depth);
  }

  Trees trees_;
  const Camera& camera_;
  const CutOptions& options_;
  const TileStates& states_;
  const TextureStates& textures_;
  double corner_cosine_ = 1;
  double most_gain_ = 1;
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
  const Place& first = places_.front();
  const Place& last = places_.back();
  const double span = last.seconds - first.seconds;
  const glm::dvec3 velocity = (last.eye - first.eye) / span;
  glm::dvec3 way = velocity * seconds;
  const Place& middle = places_[places_.size() / 2];
  if (first.seconds < middle.seconds && middle.seconds < last.seconds) {
    // Newton's form: the second divided difference bends the chord.
    const glm::dvec3 before = (middle.eye - first.eye) / (middle.seconds - first.seconds);
    const glm::dvec3 bend = (velocity - before) / (last.seconds - middle.seconds) * seconds * (seconds + span);
    const double length = glm::length(bend);
    if (length > 0) way += bend * std::min(1.0, glm::length(velocity) * seconds / length);
  }
  out.eye += way;
  out.target += way;
  return out;
}

std::vector<cache::TileRef> prefetch(Trees trees, const Camera& ahead, const CutOptions& options,
                                     const TileStates& states, const TextureStates& textures, std::size_t most) {
  return SphereWalk(trees, ahead, options, states, textures).run(most);
}

}  // namespace tintree::render
