#pragma once

#include <span>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace tintree::render {

/// Unit vectors of the picture in the world frame.
struct CameraAxes {
  glm::dvec3 right;
  glm::dvec3 up;
  glm::dvec3 forward;
};

/// A perspective view. World frame: x east, y north, z up, metres (codec/grid_frame.h). All that reaches
/// the graphics card is relative to the eye and was subtracted in double, so that a world of any size
/// keeps its millimetres. A plain value.
struct Camera {
  glm::dvec3 eye{0, 0, 0};
  glm::dvec3 target{0, 1, 0};             ///< What the middle of the picture shows; apart from the eye.
  double fov_y_rad = 0.7853981633974483;  ///< Field of view from the lower to the upper edge, under pi.
  int width_px = 1280;
  int height_px = 720;

  /// The upper edge is up; for a view straight down or up it is north.
  CameraAxes axes() const;
  double aspect() const { return static_cast<double>(width_px) / height_px; }
  /// Half the picture's width and height at depth 1.
  double tan_half_x() const { return tan_half_y() * aspect(); }
  double tan_half_y() const;
  /// Pixels that one metre across the view spans at depth one metre: height_px / (2 tan(fov_y / 2)).
  double focal_px() const;

  /// How far a vertical metre can move a point on the screen, as a factor of focal_px() / depth, anywhere
  /// in the picture. A vertical shift e of a point at depth d and image position (u, v) = (right/d, up/d)
  /// moves it by  e * focal_px / d * |(-u s, c - v s)|,  c and s being the vertical's parts along the
  /// picture's up and along the view; the largest over |u| <= tan_half_x, |v| <= tan_half_y is
  ///   sqrt((tan_half_x s)^2 + (|c| + tan_half_y |s|)^2):
  /// 1 for a level view, about 1.1 at an oblique one, under 1 from straight above.
  double vertical_gain() const;

  /// World axes to eye axes (x right, y up, z backward), for positions relative to the eye.
  glm::dmat4 view_rotation() const;
  /// Eye axes to clip coordinates; reversed depth without a far plane: near_m / depth is what a depth
  /// buffer of range 0 to 1 holds. `zero_to_one`: clip depth runs from 0 to 1 (clip control); else from
  /// -1 to 1, with the same values in the buffer but less precision.
  glm::dmat4 projection(double near_m, bool zero_to_one) const;

  /// Direction from the eye through a position of the picture (pixels from the left and the top), scaled to
  /// depth 1.
  glm::dvec3 ray(double x_px, double y_px) const;
};

/// A view from `azimuth_rad` (where the eye stands, clockwise from north; pi is south) and
/// `elevation_rad` above the horizon, as near as it can be with all `points` inside the picture less
/// `margin` (a share of its size).
Camera overview(std::span<const glm::dvec3> points, double azimuth_rad, double elevation_rad, int width_px,
                int height_px, double margin = 0.03);

}  // namespace tintree::render
