#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "apps/view/controls.h"
#include "apps/view/flight_deck.h"
#include "apps/view/frame_rate.h"
#include "apps/view/hud.h"
#include "apps/view/pilot.h"
#include "apps/view/view_options.h"
#include "cache/tile_store.h"
#include "codec/error.h"
#include "render/line_drawer.h"
#include "render/offscreen_target.h"
#include "render/terrain_scene.h"
#include "render/text_drawer.h"

struct GLFWwindow;

namespace tintree::view {

/// What the window shows, and what the user does to it (controls.h). Sleeps while nothing changes. For the thread
/// whose context is current.
class Viewer {
 public:
  /// What is drawn with.
  struct Tools {
    const render::GlFunctions& gl;
    render::TerrainScene& scene;
    render::TextDrawer text;
    render::LineDrawer lines;
  };

  /// Everything that is passed by reference must outlive it.
  Viewer(GLFWwindow* window, Tools tools, const cache::Manifest& manifest, const ViewOptions& options,
         const render::Camera& camera, std::optional<render::Flight> flight);

  /// Until the window is closed. Fails with kIo when the driver refuses a frame, with kStopped on a signal.
  Expected<void> run();

  struct Summary {
    std::uint64_t frames = 0;
    std::uint64_t rests = 0;  ///< How often it has slept for want of anything to draw.
    std::uint64_t tile_errors = 0;
    double pixel_error = 1;
    render::Camera camera;
  };
  Summary summary() const;

 private:
  struct Notice {
    std::string text;
    double until_s = 0;
  };

  static Viewer& self(GLFWwindow* window);
  void listen();
  void on_wheel(double steps);
  void on_cursor(double x, double y);
  void on_button(int button, bool pressed, bool shift);
  void on_key(int key, bool shift);
  void once(Action action);

  bool held(Action action) const;
  double axis(Action more, Action less) const;
  /// Pixels of the frame a screen unit of the cursor.
  double scale() const;
  glm::dvec2 cursor_px() const { return cursor_ * scale(); }

  void advance(double seconds);
  /// Sleeps until something happens, or for a moment.
  void nap();
  /// Whether it was asked to.
  bool turn_sun(double seconds);
  /// Keeps the frame as large as the window's. False while there is nothing to draw into.
  Expected<bool> fit_target();
  void draw_scene();
  void present();
  HudText hud_text() const;
  void take_tile_errors();
  void tell_of_memory();

  GroundSense sense_ground();
  /// To standard error and onto the picture.
  void report(const Error& error);
  void notify(const std::string& text);
  void drop_old_notices();
  void change_pixel_error(double factor);
  void toggle_freeze();
  void toggle_record();
  void toggle_play();
  void save_picture(bool with_text);

  GLFWwindow* window_;
  Tools tools_;
  const cache::Manifest& manifest_;
  const ViewOptions& options_;
  Pilot pilot_;
  FlightDeck flights_;
  render::Style style_;
  bool boxes_ = false;
  bool statistics_ = true;
  bool help_ = false;
  std::optional<render::Camera> frozen_;  ///< Whose tiles are drawn.

  std::optional<render::OffscreenTarget> target_;
  glm::ivec2 refused_px_{0, 0};  ///< A size of the window that the driver makes no frame of.
  Readings readings_;
  FrameRate frame_rate_;
  std::deque<Notice> notices_;
  glm::dvec2 cursor_{0, 0};  ///< Screen units.
  bool dragging_ = false;
  int pressed_ = -1;  ///< The button pressed last, and when and where.
  double pressed_at_s_ = -1;
  glm::dvec2 pressed_at_{0, 0};
  double now_s_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t rests_ = 0;
  std::uint64_t tile_errors_ = 0;
  bool told_of_memory_ = false;
  bool moving_ = false;     ///< By itself: the next frame differs from this one, whatever the user does.
  bool stale_ = true;       ///< The scene has to be drawn again.
  bool text_stale_ = true;  ///< The text over it has.
};

}  // namespace tintree::view
