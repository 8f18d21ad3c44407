#include "render/frustum.h"

#include <algorithm>
#include <cmath>

namespace tintree::render {

Frustum::Frustum(const Camera& camera) : eye_(camera.eye) {
  const CameraAxes a = camera.axes();
  const double x = camera.tan_half_x();
  const double y = camera.tan_half_y();
  inward_ = {a.forward * x + a.right, a.forward * x - a.right, a.forward * y + a.up, a.forward * y - a.up, a.forward};
  corner_cosine_ = 1 / std::sqrt(1 + x * x + y * y);
}

double Frustum::largest(const glm::dvec3& n, const cache::Box& box) const {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    sum += n[i] * ((n[i] > 0 ? box.max[axis] : box.min[axis]) - eye_[i]);
  }
  return sum;
}

double Frustum::smallest(const glm::dvec3& n, const cache::Box& box) const { return -largest(-n, box); }

bool Frustum::outside(const cache::Box& box) const {
  return std::ranges::any_of(inward_, [&](const glm::dvec3& n) { return largest(n, box) < 0; });
}

double Frustum::nearest_depth_m(const cache::Box& box) const {
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    const double off = std::max({box.min[axis] - eye_[i], eye_[i] - box.max[axis], 0.0});
    squared += off * off;
  }
  return std::max(smallest(inward_[4], box), std::sqrt(squared) * corner_cosine_);
}

double Frustum::farthest_depth_m(const cache::Box& box) const { return largest(inward_[4], box); }

}  // namespace tintree::render
