#include "apps/audit/view_frame.h"

#include <array>
#include <cmath>

namespace tintree::audit {
namespace {

/// Outlines are looked for no farther away than this.
constexpr double kMostReachPx = 16;

}  // namespace

ViewFrame::ViewFrame(const codec::TreeLayout& layout, const render::Camera& camera, double limit_px)
    : layout_(layout),
      camera_(camera),
      axes_(camera.axes()),
      focal_px_(camera.focal_px()),
      limit_px_(limit_px),
      reach_(static_cast<int>(std::ceil(std::min(limit_px, kMostReachPx) - 1e-6))) {}

glm::dvec3 ViewFrame::ray(std::size_t pixel) const {
  const auto width = static_cast<std::size_t>(camera_.width_px);
  return camera_.ray(static_cast<double>(pixel % width) + 0.5, static_cast<double>(pixel / width) + 0.5);
}

GridRay ViewFrame::grid_ray(const glm::dvec3& ray) const {
  return {{column(camera_.eye), row(camera_.eye), camera_.eye.z}, {column(ray), row(ray), ray.z}};
}

double ViewFrame::distance_px(const glm::dvec3& a, const glm::dvec3& b) const {
  const auto at = [this](const glm::dvec3& point) {
    const glm::dvec3 p = point - camera_.eye;
    const double depth = glm::dot(p, axes_.forward);
    return std::array{focal_px_ * glm::dot(p, axes_.right) / depth, focal_px_ * glm::dot(p, axes_.up) / depth};
  };
  const auto p = at(a);
  const auto q = at(b);
  return std::hypot(p[0] - q[0], p[1] - q[1]);
}

}  // namespace tintree::audit
