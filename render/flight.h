#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "codec/error.h"
#include "render/camera.h"

namespace tintree::render {

/// One place on a flight. World frame, metres.
struct Keyframe {
  double seconds = 0;
  glm::dvec3 eye{0};
  glm::dvec3 target{0};  ///< Apart from the eye.
};

/// A camera's path through keyframes, on which nothing jerks: eye and target run along cubic Hermite curves
/// (velocity at a keyframe: that of the parabola through it and its two neighbours), so position and velocity
/// are continuous, and evenly spaced keyframes on a line give uniform motion along it. Immutable; any thread.
///
/// As JSON (docs/guide.md, Flights):
///   {"fov_y_deg": 45, "keyframes": [{"seconds": 0, "eye_m": [x, y, z], "target_m": [x, y, z]}, ...]}
/// In place of target_m a keyframe may have azimuth_deg (clockwise from north) and elevation_deg (above level).
class Flight {
 public:
  static constexpr double kDefaultFovRad = 0.7853981633974483;
  static constexpr double kLeastApart_s =
      0.001;                                 ///< Keyframes that are nearer in time would throw the camera far away.
  static constexpr double kLongest_s = 1e6;  ///< Eleven days.

  /// Fails with kBadData, naming the keyframe, unless there are two or more, their times ascend by kLeastApart_s or
  /// more and by kLongest_s at most together, all numbers are finite, every target is apart from its eye and the field
  /// of view lies within 1 to 170 degrees.
  static Expected<Flight> create(std::vector<Keyframe> keyframes, double fov_y_rad = kDefaultFovRad);
  /// `where` names the text in messages. Fails with kBadData; the message says which member is wrong and what is
  /// wanted.
  static Expected<Flight> from_json(const std::string& text, const std::string& where);
  /// Fails with kIo when the file cannot be read, else as from_json.
  static Expected<Flight> load(const std::string& path);

  /// What from_json reads back to the same flight.
  std::string to_json() const;

  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  double begin_s() const { return keyframes_.front().seconds; }
  double end_s() const { return keyframes_.back().seconds; }
  double fov_y_rad() const { return fov_y_rad_; }

  /// The view at a time; before the begin and after the end it stands still.
  Camera at(double seconds, int width_px, int height_px) const;

 private:
  Flight() = default;

  std::vector<Keyframe> keyframes_;
  double fov_y_rad_ = kDefaultFovRad;
};

}  // namespace tintree::render
