#pragma once

#include <functional>
#include <optional>

#include "apps/view/navigation.h"
#include "render/picking.h"

namespace tintree::view {

/// What the pilot knows of the ground.
struct GroundSense {
  /// Where a ray meets it first.
  std::function<std::optional<glm::dvec3>(const render::Ray&)> pick;
  /// The lowest that an eye may be over a place (x, y), metres; none where there is no ground.
  std::function<std::optional<double>(double x_m, double y_m)> floor_m;
};

/// Turns what mouse and keys ask into the camera's way. The eye never goes underground. Places are pixels of the
/// frame. For one thread.
class Pilot {
 public:
  Pilot(const render::Camera& home, const NavigationLimits& limits, GroundSense ground);

  const render::Camera& camera() const { return camera_; }
  bool fly_mode() const { return fly_mode_; }
  void toggle_fly_mode() { fly_mode_ = !fly_mode_; }
  void resize(int width_px, int height_px);
  /// Takes over a view from elsewhere, as it is.
  void take(const render::Camera& camera);

  enum class Drag { kOrbit, kLook, kPan };
  void begin_drag(Drag drag, double x_px, double y_px);
  void drag_to(double x_px, double y_px);
  void end_drag() { drag_.reset(); }

  /// `steps` towards the ground under the cursor, or away from it.
  void zoom_by(double steps, double x_px, double y_px);
  void go_there(double x_px, double y_px);
  void look_there(double x_px, double y_px);
  void go_home();

  /// Moves on by `seconds` as keys and a glide that has begun ask. True when the camera moved, or will with the
  /// next call.
  bool advance(double seconds, const Motion& motion, bool fast);

  /// The ground under a place of the picture.
  std::optional<glm::dvec3> ground_under(double x_px, double y_px) const;
  /// The eye's height over the ground, or over the target where there is none below it.
  double height_m() const;

 private:
  void set(const render::Camera& camera, bool lift_target);
  void glide_to(const render::Camera& camera);

  struct Glide {
    render::Camera from;
    render::Camera to;
    double t = 0;
  };
  struct Dragged {
    Drag drag;
    double x_px;
    double y_px;
    glm::dvec3 grabbed;
  };

  render::Camera home_;
  render::Camera camera_;
  NavigationLimits limits_;
  GroundSense ground_;
  bool fly_mode_ = false;
  std::optional<Glide> glide_;
  std::optional<Dragged> drag_;
};

}  // namespace tintree::view
