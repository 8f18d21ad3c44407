#pragma once

#include <array>
#include <cstddef>

#include "cache/occluder.h"
#include "cache/tile_bounds.h"
#include "codec/grid_frame.h"
#include "render/camera.h"

namespace tintree::render {

/// What the ground seen so far hides of what lies behind it (Wahl et al. 2004, section 5, Occlusion Culling;
/// Lloyd and Egbert 2002): for each direction of the picture a lower bound of the horizon. Ground is a height
/// field, so that from an eye above it all that is farther and lower than the horizon is hidden. No query to
/// the graphics card, no stall: a few microseconds a tile on the CPU, from the lines of cache::Occluder.
///
/// Tiles are to come front to back. A tile that the horizon hides lies behind others of the same picture in
/// every pixel that it covers, so leaving it out changes nothing (kMarginPx allows for the rasteriser's
/// rounding and for skirts). It hides nothing where that cannot be known: until place_eye() has found the eye
/// above closed ground, behind holes, for views so steep that a corner of the picture looks straight down.
///
/// Directions are those of a level camera with the view's azimuth: u = right / ahead, v = up / ahead in metres.
/// A plain value of 1.3 KiB: copying it is how a walk takes back what it has added.
class Horizon {
 public:
  /// How far below the horizon what is hidden must lie.
  static constexpr double kMarginPx = 3;

  /// A horizon that hides nothing.
  Horizon() = default;
  explicit Horizon(const Camera& camera);

  /// False when it will hide nothing whatever comes; it then costs nothing.
  bool usable() const { return usable_; }
  /// What is under the eye, once: whether it is known that the eye is above it. Without it nothing is hidden.
  void place_eye(bool above_ground);
  bool placed() const { return placed_; }

  /// True only when no point of the box can be seen over the ground added so far.
  bool hides(const cache::Box& box) const;
  /// Adds a tile that is drawn, with its surface up to `lowered_m` lower than its lines say. One with a hole
  /// counts as open().
  void add(const cache::Occluder& occluder, const codec::TreeLayout& layout, double lowered_m = 0);
  /// These cells have holes: rays through them may pass under what comes behind, which hides nothing there.
  void open(const codec::CellRect& cells, const codec::TreeLayout& layout);

 private:
  static constexpr std::size_t kBins = 256;

  /// A place in the plane, relative to the eye: metres ahead and to the right.
  struct Plan {
    double ahead = 0;
    double right = 0;
  };
  struct Bins {
    std::size_t first = 0;
    std::size_t end = 0;
  };

  Plan plan(double x_m, double y_m) const;
  /// The bins that the plan's convex hull of corners reaches; all when one of them is not ahead.
  template <typename Corners>
  Bins reach(const Corners& corners) const;
  /// A line from `begin` in equal steps, kLines heights.
  void add_line(Plan begin, Plan step, const cache::Occluder::Line& heights, double lowered_m);
  /// Raises bins by a chain of points in (bin, v), from left to right; a bin counts where the chain crosses it all.
  void raise(const std::array<std::array<double, 2>, cache::Occluder::kLines>& chain, std::size_t points);

  bool usable_ = false;
  bool placed_ = false;
  double eye_x_ = 0, eye_y_ = 0, eye_z_ = 0;
  double ahead_x_ = 0, ahead_y_ = 1;  ///< Unit vector of the level view.
  double u_low_ = 0;                  ///< u at the left end of bin 0.
  double bins_per_u_ = 0;
  double margin_ = 0;             ///< kMarginPx as a difference of v.
  std::array<float, kBins> v_{};  ///< The horizon's lower bound.
  std::array<bool, kBins> open_{};
};

}  // namespace tintree::render
