#pragma once

#include <array>
#include <optional>

#include "cache/tile_bounds.h"
#include "render/camera.h"

namespace tintree::render {

/// How far vertical errors move what a camera sees. Immutable; safe to share between threads.
///
/// In the camera's axes (right, up, ahead) the vertical is u = (0, uy, uz), and a point at depth Z and image position
/// (X, Y) = (right / Z, up / Z). Displaced vertically by t it comes to depth Z' = Z + t uz and moves on the screen by
/// exactly
///   focal_px * |t| * g / Z',  g = |(uz X, uy - uz Y)|,
/// where g is 0 at the point that all verticals' pictures meet in, and 1 at the horizon of a level view. So straight
/// below the eye a vertical error moves nothing.
class ScreenError {
 public:
  /// Nowhere does a vertical metre count for less than this share of a metre across the view. It bounds the vertical
  /// error, in pixels' footprints, by its reciprocal.
  static constexpr double kLeastGain = 0.5;

  explicit ScreenError(const Camera& camera);

  /// Upper bound, pixels, of what any vertical displacement of up to `error_m` >= 0 moves on the screen of which one
  /// end is in the box and one end, the same or the other, is in the picture. Infinite when the eye is in or next to
  /// the box; nothing when no point within error_m above or below the box is in the picture.
  /// Cost: about 0.2 us. Never smaller for a box that holds this one, or for a larger error.
  std::optional<double> bound_px(const cache::Box& box, double error_m) const;

 private:
  struct Sight;
  struct Extremes;
  bool add_face(const std::array<glm::dvec3, 4>& corners, Extremes& out) const;
  Sight sight(const glm::dvec3& p) const;
  static double largest_between(const Sight& from, const Sight& to);

  Camera camera_;
  CameraAxes axes_;
  double focal_px_;
  double tan_x_, tan_y_;
};

}  // namespace tintree::render
