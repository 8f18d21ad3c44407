#include "apps/view/navigation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace tintree::view {
namespace {

constexpr double kLowest = -5 * std::numbers::pi / 180;
constexpr double kHighest = 89.9 * std::numbers::pi / 180;

double distance(const render::Camera& camera) { return glm::length(camera.eye - camera.target); }

void shift(render::Camera& camera, const glm::dvec3& by) {
  camera.eye += by;
  camera.target += by;
}

/// The direction ahead, level with the ground.
glm::dvec3 level_ahead(const render::Camera& camera) { return glm::cross(glm::dvec3(0, 0, 1), camera.axes().right); }

}  // namespace

render::Camera orbit(render::Camera camera, double dx_px, double dy_px) {
  const glm::dvec3 away = camera.eye - camera.target;
  const double reach = glm::length(away);
  const double turn = std::numbers::pi / camera.width_px;
  const glm::dvec3 right = camera.axes().right;
  // The eye stands opposite to the level direction ahead, which also holds when it looks straight down.
  const double azimuth = std::atan2(right.y, right.x) - dx_px * turn;
  const double elevation =
      std::clamp(std::asin(std::clamp(away.z / reach, -1.0, 1.0)) + dy_px * turn, kLowest, kHighest);
  const glm::dvec3 ahead(-std::sin(azimuth), std::cos(azimuth), 0);
  camera.eye = camera.target + reach * (glm::dvec3(0, 0, std::sin(elevation)) - std::cos(elevation) * ahead);
  return camera;
}

render::Camera pan(render::Camera camera, double dx_px, double dy_px) {
  const render::CameraAxes axes = camera.axes();
  const double metres_per_px = distance(camera) / camera.focal_px();
  // Seen at a slant, a pixel up spans more ground.
  const double stretch = 1 / std::max(std::abs(axes.forward.z), 0.2);
  shift(camera, (-dx_px * axes.right + dy_px * stretch * level_ahead(camera)) * metres_per_px);
  return camera;
}

render::Camera zoom(render::Camera camera, const glm::dvec3& point, double factor, const NavigationLimits& limits) {
  const double before = distance(camera);
  factor = std::clamp(before * factor, limits.nearest_m, limits.farthest_m) / before;
  camera.eye = point + (camera.eye - point) * factor;
  camera.target = point + (camera.target - point) * factor;
  return camera;
}

render::Camera walk(render::Camera camera, double ahead, double right) {
  shift(camera, (level_ahead(camera) * ahead + camera.axes().right * right) * distance(camera));
  return camera;
}

render::Camera anchor(render::Camera camera, double depth_m, const NavigationLimits& limits) {
  camera.target = camera.eye + camera.axes().forward * std::clamp(depth_m, limits.nearest_m, limits.farthest_m);
  return camera;
}

glm::dvec3 point_under(const render::Camera& camera, double x_px, double y_px, std::optional<double> depth_m) {
  const glm::dvec3 ray = camera.ray(x_px, y_px);
  if (depth_m) return camera.eye + ray * *depth_m;
  const double depth = ray.z == 0 ? -1 : (camera.target.z - camera.eye.z) / ray.z;
  return depth > 0 && depth < 4 * distance(camera) ? camera.eye + ray * depth : camera.target;
}

}  // namespace tintree::view
