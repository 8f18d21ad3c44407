#include "apps/view/flight_deck.h"

#include <utility>

namespace tintree::view {
namespace {

constexpr double kBetweenKeyframes_s = 0.25;

}  // namespace

void FlightDeck::begin_recording(const render::Camera& camera, double now_s) {
  stop();
  recording_ = true;
  recording_since_ = now_s;
  keyframes_.clear();
  add(camera, now_s);
}

void FlightDeck::note(const render::Camera& camera, double now_s) {
  if (!recording_) return;
  const double at = now_s - recording_since_;
  if (at >= keyframes_.back().seconds + kBetweenKeyframes_s) add(camera, now_s);
}

void FlightDeck::add(const render::Camera& camera, double now_s) {
  const double at = now_s - recording_since_;
  if (keyframes_.empty() || at >= keyframes_.back().seconds + render::Flight::kLeastApart_s)
    keyframes_.push_back({at, camera.eye, camera.target});
}

Expected<render::Flight> FlightDeck::end_recording(const render::Camera& camera, double now_s) {
  add(camera, now_s);
  recording_ = false;
  auto flight = render::Flight::create(std::exchange(keyframes_, {}), camera.fov_y_rad);
  if (flight) flight_ = *flight;
  return flight;
}

bool FlightDeck::play(double now_s) {
  if (!flight_) return false;
  playing_since_ = now_s;
  return true;
}

std::optional<render::Camera> FlightDeck::view(double now_s, int width_px, int height_px) {
  if (!playing_since_) return std::nullopt;
  const double at = flight_->begin_s() + now_s - *playing_since_;
  if (at >= flight_->end_s()) stop();
  return flight_->at(at, width_px, height_px);
}

}  // namespace tintree::view
