#pragma once

#include <optional>

#include "render/camera.h"

namespace tintree::view {

// Steps of a camera through the world, as pure functions. Places on the picture are pixels from its left and top.

/// How far a camera may go; metres.
struct NavigationLimits {
  double nearest_m = 1;  ///< Between eye and target.
  double farthest_m = 1e7;
};

/// Which way the keys go: -1 to 1 each.
struct Motion {
  double ahead = 0;
  double right = 0;
  double up = 0;
};

/// Turns the camera round its target as a drag of the mouse by (dx, dy) pixels (right, down) asks: half a
/// turn for the picture's width. Keeps the distance; the elevation stays between -5 and 89.9 degrees.
render::Camera orbit(render::Camera camera, double dx_px, double dy_px);

/// Turns the view about the eye, so that the landscape follows the mouse. Keeps the distance of the target; the
/// elevation of the view stays within 89.9 degrees.
render::Camera look_round(render::Camera camera, double dx_px, double dy_px);

/// Moves eye and target level with the ground so that `grabbed`, a place in the world, comes to be seen at a place of
/// the picture. Where that place shows no point of its level in front of the eye, or one beyond 20 times the eye's
/// distance from it, the camera stays.
render::Camera pan(render::Camera camera, const glm::dvec3& grabbed, double x_px, double y_px);

/// Brings the camera to `factor` of its distance from `point`, which keeps its place in the picture.
render::Camera zoom(render::Camera camera, const glm::dvec3& point, double factor, const NavigationLimits& limits);

/// Moves eye and target by `metres` times the motion: ahead and right level with the ground; `along_view`: ahead where
/// the camera looks.
render::Camera move(render::Camera camera, const Motion& motion, double metres, bool along_view);

/// How fast keys move an eye at a height over the ground: its own height in a second, and no slower than a
/// crawl at which limits.nearest_m takes a second.
double speed_m_per_s(double height_m, const NavigationLimits& limits);

/// Puts the target where the picture's middle meets the ground; the picture stays as it is.
render::Camera anchor(render::Camera camera, double depth_m, const NavigationLimits& limits);

/// Looks at a point from where the eye is. A point too close to the eye changes nothing.
render::Camera look_at(render::Camera camera, const glm::dvec3& point);

/// Looks at a point in the same direction as now, from a third of its distance.
render::Camera go_to(render::Camera camera, const glm::dvec3& point, const NavigationLimits& limits);

/// Lifts an eye that is lower than `floor_m`. `with_target`: the target too, so that the direction stays.
render::Camera keep_above(render::Camera camera, double floor_m, bool with_target);

/// A view on the way between two; t from 0 to 1, slow at both ends. Eyes go straight, directions turn, distances to
/// the target change by equal ratios. Size and field of view are those of `to`.
render::Camera between(const render::Camera& from, const render::Camera& to, double t);

/// The place under a position of the picture where no ground was hit: where the ray meets the level of the target;
/// the target itself when it does not within 4 times its distance.
glm::dvec3 point_on_level(const render::Camera& camera, double x_px, double y_px);

}  // namespace tintree::view
