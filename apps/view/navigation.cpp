#include "apps/view/navigation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tintree::view {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kLowest = -5 * kDegree;
constexpr double kHighest = 89.9 * kDegree;

double distance(const render::Camera& camera) { return glm::length(camera.eye - camera.target); }

void shift(render::Camera& camera, const glm::dvec3& by) {
  camera.eye += by;
  camera.target += by;
}

/// The direction ahead, level with the ground; the axis to the right tells it for views straight down too.
glm::dvec3 level_ahead(const render::Camera& camera) { return glm::cross(glm::dvec3(0, 0, 1), camera.axes().right); }

/// Unit vector at an azimuth, the angle of the axis to the right counter-clockwise from east, and an elevation.
glm::dvec3 direction(double azimuth, double elevation) {
  const double level = std::cos(elevation);
  return {-std::sin(azimuth) * level, std::cos(azimuth) * level, std::sin(elevation)};
}

struct Angles {
  double azimuth;
  double elevation;
};

/// Of the way the camera looks, for direction().
Angles angles(const render::Camera& camera) {
  const render::CameraAxes axes = camera.axes();
  return {std::atan2(axes.right.y, axes.right.x), std::asin(std::clamp(axes.forward.z, -1.0, 1.0))};
}

}  // namespace

render::Camera orbit(render::Camera camera, double dx_px, double dy_px) {
  const double turn = std::numbers::pi / camera.width_px;
  const double reach = distance(camera);
  const auto [azimuth, elevation] = angles(camera);
  const double lower = std::clamp(elevation - dy_px * turn, -kHighest, std::max(-kLowest, elevation));
  camera.eye = camera.target - reach * direction(azimuth - dx_px * turn, lower);
  return camera;
}

render::Camera look_round(render::Camera camera, double dx_px, double dy_px) {
  const double turn = 1 / camera.focal_px();
  const double reach = distance(camera);
  const auto [azimuth, elevation] = angles(camera);
  const double higher = std::clamp(elevation + dy_px * turn, -kHighest, kHighest);
  camera.target = camera.eye + reach * direction(azimuth + dx_px * turn, higher);
  return camera;
}

render::Camera pan(render::Camera camera, const glm::dvec3& grabbed, double x_px, double y_px) {
  constexpr double kFarthest = 20;
  const glm::dvec3 ray = camera.ray(x_px, y_px);
  const double depth = ray.z == 0 ? -1 : (grabbed.z - camera.eye.z) / ray.z;
  if (!(depth > 0) || depth * glm::length(ray) > kFarthest * glm::length(grabbed - camera.eye)) return camera;
  glm::dvec3 by = grabbed - (camera.eye + ray * depth);
  by.z = 0;
  shift(camera, by);
  return camera;
}

render::Camera zoom(render::Camera camera, const glm::dvec3& point, double factor, const NavigationLimits& limits) {
  const double before = distance(camera);
  factor = std::clamp(before * factor, limits.nearest_m, limits.farthest_m) / before;
  camera.eye = point + (camera.eye - point) * factor;
  camera.target = point + (camera.target - point) * factor;
  return camera;
}

render::Camera move(render::Camera camera, const Motion& motion, double metres, bool along_view) {
  const render::CameraAxes axes = camera.axes();
  const glm::dvec3 ahead = along_view ? axes.forward : level_ahead(camera);
  shift(camera, (ahead * motion.ahead + axes.right * motion.right + glm::dvec3(0, 0, motion.up)) * metres);
  return camera;
}

double speed_m_per_s(double height_m, const NavigationLimits& limits) { return std::max(height_m, limits.nearest_m); }

render::Camera anchor(render::Camera camera, double depth_m, const NavigationLimits& limits) {
  camera.target = camera.eye + camera.axes().forward * std::clamp(depth_m, limits.nearest_m, limits.farthest_m);
  return camera;
}

render::Camera look_at(render::Camera camera, const glm::dvec3& point) {
  if (glm::length(point - camera.eye) > 1e-6) camera.target = point;
  return camera;
}

render::Camera go_to(render::Camera camera, const glm::dvec3& point, const NavigationLimits& limits) {
  const double reach = std::clamp(glm::length(point - camera.eye) / 3, limits.nearest_m, limits.farthest_m);
  camera.eye = point - camera.axes().forward * reach;
  camera.target = point;
  return camera;
}

render::Camera keep_above(render::Camera camera, double floor_m, bool with_target) {
  const double lift = floor_m - camera.eye.z;
  if (!(lift > 0)) return camera;
  camera.eye.z = floor_m;
  if (with_target || glm::length(camera.eye - camera.target) < 1e-6) camera.target.z += lift;
  return camera;
}

render::Camera between(const render::Camera& from, const render::Camera& to, double t) {
  const double s = glm::smoothstep(0.0, 1.0, t);
  const glm::dvec3 a = from.axes().forward;
  const glm::dvec3 b = to.axes().forward;
  const glm::dvec3 turned = glm::mix(a, b, s);
  // Opposite views have no middle; it turns at once.
  const glm::dvec3 forward = glm::length(turned) > 1e-3 ? glm::normalize(turned) : b;
  render::Camera out = to;
  out.eye = glm::mix(from.eye, to.eye, s);
  out.target = out.eye + forward * std::exp(glm::mix(std::log(distance(from)), std::log(distance(to)), s));
  return out;
}

glm::dvec3 point_on_level(const render::Camera& camera, double x_px, double y_px) {
  const glm::dvec3 ray = camera.ray(x_px, y_px);
  const double depth = ray.z == 0 ? -1 : (camera.target.z - camera.eye.z) / ray.z;
  return depth > 0 && depth < 4 * distance(camera) ? camera.eye + ray * depth : camera.target;
}

}  // namespace tintree::view
