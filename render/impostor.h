#pragma once

#include <cstdint>
#include <span>
#include <unordered_set>

#include "cache/tile_ref.h"
#include "render/camera.h"
#include "render/lod_cut.h"

namespace tintree::render {

/// Impostors (Wahl et al. 2004, section 5): ground so far away that a few metres of flight do not change its look is
/// drawn once, into a picture, and that picture stands in for it until its error has grown to what is allowed. Here are
/// the decisions; render/far_picture.h draws. Pure; any thread.
///
/// The picture lies on a sphere round the eye that it was drawn from. What is allowed in the end, `pixel_error`, is
/// shared out: the picture's ground is drawn within `pixel_error - kParallaxPx - kResamplePx`, its texels are half a
/// pixel wide, so that smoothing between them moves nothing by more than kResamplePx, and kParallaxPx is left for what
/// the sphere does not show: that nearer ground moves more than farther ground.
namespace impostor {
constexpr double kParallaxPx = 0.25;
constexpr double kResamplePx = 0.25;
/// Texels a pixel along each axis.
constexpr int kTexelsPerPx = 2;
/// The picture shows this much more than the view, along each axis, so that the view may turn.
constexpr double kMargin = 1.25;
/// Frames at the camera's present speed for which a picture has to hold, from where it was begun.
constexpr int kFrames = 24;
/// A picture is drawn over a half of the frames for which it will hold, but over no more than kMostDrawing; one that
/// would be drawn over fewer than kLeastDrawing is not worth its while.
constexpr int kLeastDrawing = 4;
constexpr int kMostDrawing = 16;
}  // namespace impostor

/// Where a picture was drawn from, and what it shows.
struct ImpostorView {
  Camera camera;         ///< Wider than the view it is for, and of its own size in texels.
  double nearest_m = 0;  ///< Distances from its eye between which all of its ground lies.
  double farthest_m = 0;

  /// Radius of the sphere: between the two so that ground at either moves by the same.
  double radius_m() const { return 2 * nearest_m * farthest_m / (nearest_m + farthest_m); }
};

/// The camera of a picture for a view.
Camera impostor_camera(const Camera& view);

/// From where on ground may be in a picture that is to hold for kFrames frames of `step_m` each; metres.
double impostor_distance_m(double step_m, const Camera& view);

/// How far, pixels, the picture shows any of its ground from where it belongs, with `now`'s eye. A point at distance t
/// from the picture's eye is shown at distance s, the radius; from an eye d metres away the angle between them is at
/// most asin(|t - s| d / ((t - d) (s - d))), which is largest at the nearest or the farthest ground.
double impostor_parallax_px(const ImpostorView& made, const Camera& now);

/// Whether the picture may stand in for its ground in this view: within kParallaxPx, and all of the view on it, with
/// kTexelsPerPx.
bool impostor_holds(const ImpostorView& made, const Camera& now);

/// For how many more frames a picture holds, at most `most`, if the camera goes on from `now` as it came there from
/// `before` within a frame: eye and target each along a straight line.
int impostor_frames(const ImpostorView& made, const Camera& before, const Camera& now, int most);

/// The shortest distance from a point to a box, and the longest; metres.
double nearest_m(const cache::Box& box, const glm::dvec3& from);
double farthest_m(const cache::Box& box, const glm::dvec3& from);

using TileSet = std::unordered_set<cache::TileRef, cache::TileRefHash>;

/// Whether tiles of the set cover all of a node: it, one above it, or all of those below it, two levels deep at most.
bool covered(const TileSet& tiles, Trees trees, std::uint32_t tree, std::uint32_t node);

}  // namespace tintree::render
