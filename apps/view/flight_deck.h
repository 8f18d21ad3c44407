#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "codec/error.h"
#include "render/camera.h"
#include "render/flight.h"

namespace tintree::view {

/// Records the camera's way and plays flights. Times are seconds of the caller's clock. For one thread.
class FlightDeck {
 public:
  /// `flight`: what play() plays until another has been recorded.
  explicit FlightDeck(std::optional<render::Flight> flight) : flight_(std::move(flight)) {}

  bool recording() const { return recording_; }
  bool playing() const { return playing_since_.has_value(); }

  void begin_recording(const render::Camera& camera, double now_s);
  /// Notes the view while recording, four times a second.
  void note(const render::Camera& camera, double now_s);
  /// Ends the recording, which becomes the flight to play. Fails as Flight::create, when it took no time.
  Expected<render::Flight> end_recording(const render::Camera& camera, double now_s);

  /// Begins to play; false when there is no flight.
  bool play(double now_s);
  void stop() { playing_since_.reset(); }
  /// The view while playing. Ends by itself behind the last keyframe, which it gives once.
  std::optional<render::Camera> view(double now_s, int width_px, int height_px);

 private:
  void add(const render::Camera& camera, double now_s);

  std::optional<render::Flight> flight_;
  std::optional<double> playing_since_;
  bool recording_ = false;
  double recording_since_ = 0;
  std::vector<render::Keyframe> keyframes_;
};

}  // namespace tintree::view
