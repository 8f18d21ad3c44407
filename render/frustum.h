#pragma once

#include <array>

#include "cache/tile_bounds.h"
#include "render/camera.h"

namespace tintree::render {

/// What a camera can see: the four sides of its picture and the plane through the eye; there is no far end.
/// Immutable; safe to share between threads.
class Frustum {
 public:
  explicit Frustum(const Camera& camera);

  /// True only when no point of the box can be seen. May be false for an unseen box near an edge of the
  /// frustum: drawing that one costs time, not correctness.
  bool outside(const cache::Box& box) const;

  /// Lower bound, metres, of the depth (distance along the view) of every *visible* point of a box: the
  /// larger of its corners' smallest depth and of its distance from the eye times the cosine of the angle
  /// between the view and the picture's corner. 0 when the eye is inside.
  double nearest_depth_m(const cache::Box& box) const;
  /// The largest depth of the box's corners.
  double farthest_depth_m(const cache::Box& box) const;

 private:
  /// Extremes of dot(n, p - eye) over the box.
  double largest(const glm::dvec3& n, const cache::Box& box) const;
  double smallest(const glm::dvec3& n, const cache::Box& box) const;

  glm::dvec3 eye_;
  std::array<glm::dvec3, 5> inward_;  ///< Normals of planes through the eye; the last is the view's direction.
  double corner_cosine_;
};

}  // namespace tintree::render
