#include "render/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace tintree::render {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Moves the camera along its view until every point just fits.
void back_off(Camera& camera, std::span<const glm::dvec3> points, double scale) {
  const CameraAxes axes = camera.axes();
  double distance = 0;
  for (const glm::dvec3& p : points) {
    const glm::dvec3 q = p - camera.target;
    const double across = std::max(std::abs(glm::dot(q, axes.right)) / (camera.tan_half_x() * scale),
                                   std::abs(glm::dot(q, axes.up)) / (camera.tan_half_y() * scale));
    distance = std::max(distance, across - glm::dot(q, axes.forward));
  }
  camera.eye = camera.target - axes.forward * std::max(distance, 1e-6);
}

/// Moves the target so that the points' projection lies in the middle of the picture.
void centre(Camera& camera, std::span<const glm::dvec3> points) {
  const CameraAxes axes = camera.axes();
  double x0 = kInfinity, x1 = -kInfinity, y0 = kInfinity, y1 = -kInfinity;
  for (const glm::dvec3& p : points) {
    const glm::dvec3 q = p - camera.eye;
    const double depth = glm::dot(q, axes.forward);
    if (depth <= 0) continue;
    const double x = glm::dot(q, axes.right) / depth;
    const double y = glm::dot(q, axes.up) / depth;
    x0 = std::min(x0, x), x1 = std::max(x1, x);
    y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
  if (x1 < x0) return;
  const double distance = glm::dot(camera.target - camera.eye, axes.forward);
  const glm::dvec3 shift = (axes.right * (x0 + x1) + axes.up * (y0 + y1)) * (0.5 * distance);
  camera.target += shift;
  camera.eye += shift;
}

}  // namespace

CameraAxes Camera::axes() const {
  const glm::dvec3 forward = glm::normalize(target - eye);
  const bool vertical = std::hypot(forward.x, forward.y) < 1e-9;
  const glm::dvec3 upward = vertical ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, upward));
  return {right, glm::cross(right, forward), forward};
}

double Camera::tan_half_y() const { return std::tan(0.5 * fov_y_rad); }

double Camera::focal_px() const { return height_px / (2 * tan_half_y()); }

double Camera::vertical_gain() const {
  const CameraAxes a = axes();
  const double s = std::abs(a.forward.z);
  return std::hypot(tan_half_x() * s, std::abs(a.up.z) + tan_half_y() * s);
}

glm::dmat4 Camera::view_rotation() const {
  const CameraAxes a = axes();
  glm::dmat4 m(1);
  for (int i = 0; i < 3; ++i) {
    m[i][0] = a.right[i];
    m[i][1] = a.up[i];
    m[i][2] = -a.forward[i];
  }
  return m;
}

glm::dmat4 Camera::projection(double near_m, bool zero_to_one) const {
  glm::dmat4 m(0);
  m[0][0] = 1 / tan_half_x();
  m[1][1] = 1 / tan_half_y();
  m[2][3] = -1;
  // Clip z is near (0 to 1), or 2 near - w with w = -z (-1 to 1).
  m[2][2] = zero_to_one ? 0 : 1;
  m[3][2] = zero_to_one ? near_m : 2 * near_m;
  return m;
}

glm::dvec3 Camera::ray(double x_px, double y_px) const {
  const CameraAxes a = axes();
  const double u = (2 * x_px / width_px - 1) * tan_half_x();
  const double v = (1 - 2 * y_px / height_px) * tan_half_y();
  return a.forward + a.right * u + a.up * v;
}

Camera overview(std::span<const glm::dvec3> points, double azimuth_rad, double elevation_rad, int width_px,
                int height_px, double margin) {
  Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  glm::dvec3 low(kInfinity), high(-kInfinity);
  for (const glm::dvec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
  camera.target = points.empty() ? glm::dvec3(0) : 0.5 * (low + high);
  const glm::dvec3 towards(std::sin(azimuth_rad) * std::cos(elevation_rad),
                           std::cos(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad));
  camera.eye = camera.target + towards;
  constexpr int kRounds = 12;  // Each round leaves less than half of what is off.
  for (int i = 0; i < kRounds; ++i) {
    back_off(camera, points, 1 - 2 * margin);
    centre(camera, points);
  }
  back_off(camera, points, 1 - 2 * margin);
  return camera;
}

}  // namespace tintree::render
