#pragma once

#include <optional>

#include "render/camera.h"

namespace tintree::view {

/// How far a camera may go; metres.
struct NavigationLimits {
  double nearest_m = 1;  ///< Between eye and target.
  double farthest_m = 1e7;
};

/// Turns the camera round its target as a drag of the mouse by (dx, dy) pixels (right, down) asks: half a
/// turn for the picture's width. Keeps the distance; the elevation stays between -5 and 89.9 degrees.
render::Camera orbit(render::Camera camera, double dx_px, double dy_px);

/// Moves eye and target level with the ground so that the target follows the mouse.
render::Camera pan(render::Camera camera, double dx_px, double dy_px);

/// Brings the camera to `factor` of its distance from `point`, which keeps its place in the picture.
render::Camera zoom(render::Camera camera, const glm::dvec3& point, double factor, const NavigationLimits& limits);

/// Moves eye and target level with the ground by shares of their distance: ahead and to the right.
render::Camera walk(render::Camera camera, double ahead, double right);

/// Puts the target where the picture's middle meets the ground; the picture stays as it is.
render::Camera anchor(render::Camera camera, double depth_m, const NavigationLimits& limits);

/// The point of the ground under a position of the picture: at `depth_m` along the view, or, where nothing
/// was drawn, where the ray meets the level of the target; the target itself when it does not.
glm::dvec3 point_under(const render::Camera& camera, double x_px, double y_px, std::optional<double> depth_m);

}  // namespace tintree::view
