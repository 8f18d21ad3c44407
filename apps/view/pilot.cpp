#include "apps/view/pilot.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

namespace tintree::view {
namespace {

constexpr double kGlideSeconds = 0.7;
constexpr double kZoomStep = 0.85;
constexpr double kFast = 5;

}  // namespace

Pilot::Pilot(const render::Camera& home, const NavigationLimits& limits, GroundSense ground)
    : home_(home), camera_(home), limits_(limits), ground_(std::move(ground)) {}

void Pilot::resize(int width_px, int height_px) {
  for (render::Camera* camera : {&home_, &camera_}) {
    camera->width_px = width_px;
    camera->height_px = height_px;
  }
  if (glide_) glide_->to.width_px = width_px, glide_->to.height_px = height_px;
}

void Pilot::take(const render::Camera& camera) {
  glide_.reset();
  camera_ = camera;
}

void Pilot::set(const render::Camera& camera, bool lift_target) {
  const auto floor = ground_.floor_m(camera.eye.x, camera.eye.y);
  camera_ = floor ? keep_above(camera, *floor, lift_target) : camera;
}

void Pilot::begin_drag(Drag drag, double x_px, double y_px) {
  glide_.reset();
  if (drag == Drag::kOrbit && fly_mode_) drag = Drag::kLook;
  // An orbit goes round what is in the middle of the picture.
  const glm::dvec3 forward = camera_.axes().forward;
  if (drag == Drag::kOrbit) {
    if (const auto ahead = ground_.pick({camera_.eye, forward}))
      camera_ = anchor(camera_, glm::length(*ahead - camera_.eye), limits_);
  }
  drag_ = Dragged{drag, x_px, y_px, ground_under(x_px, y_px).value_or(point_on_level(camera_, x_px, y_px))};
}

void Pilot::drag_to(double x_px, double y_px) {
  if (!drag_) return;
  const double dx = x_px - std::exchange(drag_->x_px, x_px);
  const double dy = y_px - std::exchange(drag_->y_px, y_px);
  if (drag_->drag == Drag::kOrbit) set(orbit(camera_, dx, dy), false);
  if (drag_->drag == Drag::kLook) set(look_round(camera_, dx, dy), true);
  if (drag_->drag == Drag::kPan) set(pan(camera_, drag_->grabbed, x_px, y_px), true);
}

void Pilot::zoom_by(double steps, double x_px, double y_px) {
  glide_.reset();
  const glm::dvec3 point = ground_under(x_px, y_px).value_or(point_on_level(camera_, x_px, y_px));
  set(zoom(camera_, point, std::pow(kZoomStep, steps), limits_), true);
}

void Pilot::go_there(double x_px, double y_px) {
  if (const auto point = ground_under(x_px, y_px)) glide_to(go_to(camera_, *point, limits_));
}

void Pilot::look_there(double x_px, double y_px) {
  if (const auto point = ground_under(x_px, y_px)) glide_to(look_at(camera_, *point));
}

void Pilot::go_home() { glide_to(home_); }

void Pilot::glide_to(const render::Camera& camera) {
  drag_.reset();
  glide_ = Glide{camera_, camera, 0};
}

bool Pilot::advance(double seconds, const Motion& motion, bool fast) {
  const bool moves = motion.ahead != 0 || motion.right != 0 || motion.up != 0;
  if (moves) {
    glide_.reset();
    const double metres = speed_m_per_s(height_m(), limits_) * seconds * (fast ? kFast : 1);
    set(move(camera_, motion, metres, fly_mode_), true);
  }
  if (!glide_) return moves;
  glide_->t = std::min(glide_->t + seconds / kGlideSeconds, 1.0);
  // At its end it is exactly there.
  set(glide_->t < 1 ? between(glide_->from, glide_->to, glide_->t) : glide_->to, true);
  if (glide_->t >= 1) glide_.reset();
  return true;
}

std::optional<glm::dvec3> Pilot::ground_under(double x_px, double y_px) const {
  return ground_.pick({camera_.eye, camera_.ray(x_px, y_px)});
}

double Pilot::height_m() const {
  const auto below = ground_.pick({camera_.eye, {0, 0, -1}});
  return below ? camera_.eye.z - below->z : std::abs(camera_.eye.z - camera_.target.z);
}

}  // namespace tintree::view
