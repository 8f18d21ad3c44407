#include "render/impostor.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace tintree::render {
namespace {

constexpr int kLookBelow = 2;

/// The most pixels that a radian takes anywhere in the picture: in its corners, away from the middle.
double pixels_per_radian(const Camera& camera) {
  return camera.focal_px() * (1 + std::pow(camera.tan_half_x(), 2) + std::pow(camera.tan_half_y(), 2));
}

bool covered_from_below(const TileSet& tiles, const cache::TileBounds& bounds, std::uint32_t tree, std::uint32_t node,
                        int look_below) {
  const cache::TileNode& n = bounds.nodes()[node];
  if (tiles.contains({n.id, tree})) return true;
  if (look_below == 0 || n.child_mask == 0) return false;
  for (int i = 0; i < std::popcount(unsigned{n.child_mask}); ++i) {
    if (!covered_from_below(tiles, bounds, tree, n.first_child + static_cast<std::uint32_t>(i), look_below - 1))
      return false;
  }
  return true;
}

}  // namespace

Camera impostor_camera(const Camera& view) {
  Camera out = view;
  out.fov_y_rad = 2 * std::atan(impostor::kMargin * view.tan_half_y());
  const double texels = impostor::kMargin * impostor::kTexelsPerPx;
  out.width_px = static_cast<int>(std::ceil(texels * view.width_px));
  out.height_px = static_cast<int>(std::ceil(texels * view.height_px));
  return out;
}

double impostor_distance_m(double step_m, const Camera& view) {
  // With no end of the ground the sphere is at twice the distance: half of the parallax is left.
  return impostor::kFrames * step_m * (pixels_per_radian(view) / (2 * impostor::kParallaxPx) + 2);
}

double impostor_parallax_px(const ImpostorView& made, const Camera& now) {
  const double moved = glm::length(now.eye - made.camera.eye);
  if (moved == 0) return 0;
  if (moved >= made.nearest_m) return std::numeric_limits<double>::infinity();
  const double s = made.radius_m();
  double sine = 0;
  for (const double t : {made.nearest_m, made.farthest_m})
    sine = std::max(sine, std::abs(t - s) * moved / ((t - moved) * (s - moved)));
  if (sine >= 1) return std::numeric_limits<double>::infinity();
  return std::asin(sine) * pixels_per_radian(now);
}

bool impostor_holds(const ImpostorView& made, const Camera& now) {
  if (impostor_parallax_px(made, now) > impostor::kParallaxPx) return false;
  if (made.camera.focal_px() < 0.999 * impostor::kTexelsPerPx * now.focal_px()) return false;
  const CameraAxes axes = made.camera.axes();
  // Beside the picture's rim there is room for how far the eye has moved.
  const double moved = glm::length(now.eye - made.camera.eye) / made.radius_m();
  for (const double x : {0.0, static_cast<double>(now.width_px)}) {
    for (const double y : {0.0, static_cast<double>(now.height_px)}) {
      const glm::dvec3 ray = glm::normalize(now.ray(x, y));
      const double depth = glm::dot(ray, axes.forward) - 2 * moved;
      if (depth <= 0 || std::abs(glm::dot(ray, axes.right)) + 2 * moved > depth * made.camera.tan_half_x() ||
          std::abs(glm::dot(ray, axes.up)) + 2 * moved > depth * made.camera.tan_half_y())
        return false;
    }
  }
  return true;
}

int impostor_frames(const ImpostorView& made, const Camera& before, const Camera& now, int most) {
  const auto holds = [&](int frames) {
    Camera then = now;
    then.eye += static_cast<double>(frames) * (now.eye - before.eye);
    then.target += static_cast<double>(frames) * (now.target - before.target);
    return impostor_holds(made, then);
  };
  // It holds at `held` and does not at `lost`.
  int held = -1, lost = most + 1;
  while (lost - held > 1) {
    const int middle = held + (lost - held) / 2;
    (holds(middle) ? held : lost) = middle;
  }
  return std::max(held, 0);
}

double nearest_m(const cache::Box& box, const glm::dvec3& from) {
  glm::dvec3 away(0);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    away[i] = std::max({box.min[axis] - from[i], from[i] - box.max[axis], 0.0});
  }
  return glm::length(away);
}

double farthest_m(const cache::Box& box, const glm::dvec3& from) {
  glm::dvec3 away(0);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    away[i] = std::max(std::abs(box.min[axis] - from[i]), std::abs(box.max[axis] - from[i]));
  }
  return glm::length(away);
}

bool covered(const TileSet& tiles, Trees trees, std::uint32_t tree, std::uint32_t node) {
  const cache::TileBounds& bounds = *trees[tree];
  codec::TileId id = bounds.nodes()[node].id;
  while (!tiles.contains({id, tree})) {
    if (id.level == 0) return covered_from_below(tiles, bounds, tree, node, kLookBelow);
    id = bounds.layout().parent(id);
  }
  return true;
}

}  // namespace tintree::render
