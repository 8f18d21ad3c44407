#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

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
  /// `off_px`: what the ground that hides, and that which is hidden, are drawn off their lines and boxes: vertically by
  /// no more than so many pixels measure across the view at their distance.
  explicit Horizon(const Camera& camera, double off_px = 0);

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
  struct ChainPoint {
    double bin = 0;
    double v = 0;
  };
  using Chain = std::array<ChainPoint, cache::Occluder::kLines>;
  /// Raises the bins that a chain of points, from left to right, crosses from end to end.
  void raise(std::span<const ChainPoint> chain);

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

/// Whether to leave out what nearer ground hides. The picture is the same either way.
enum class Occlusion { kOff, kWhereItPays, kAlways };

/// Turns occlusion off where it does not pay: after a frame in which the horizon hid little, the next frames do
/// without and one in kRest tries again. What it costs elsewhere is thus bounded by a share of kRest of a
/// cut's time; the picture is the same either way. Depends on the frames' figures alone, not on a clock.
class OcclusionSwitch {
 public:
  static constexpr std::uint32_t kRest = 16;
  /// Whether this frame's cut is to look for what is hidden.
  bool on(Occlusion wish) const {
    return wish == Occlusion::kAlways || (wish == Occlusion::kWhereItPays && rest_ == 0);
  }
  /// What came of it: tiles drawn, nodes hidden.
  void note_frame(std::size_t drawn, std::size_t hidden) {
    if (rest_ > 0) {
      --rest_;
    } else if (8 * hidden < drawn) {
      rest_ = kRest - 1;
    }
  }

 private:
  std::uint32_t rest_ = 0;  ///< Frames still to go without.
};

}  // namespace tintree::render
