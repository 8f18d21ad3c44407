#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tintree::view {

/// All that the user can ask of the window.
enum class Action {
  // While the mouse is dragged.
  kOrbit,
  kLook,
  kPan,
  // Where the mouse points.
  kZoom,
  kGoThere,
  kLookThere,
  // As long as a key is held.
  kAhead,
  kBack,
  kLeft,
  kRight,
  kUp,
  kDown,
  kFaster,
  kSunEast,
  kSunWest,
  kSunUp,
  kSunDown,
  // Once a key.
  kHome,
  kFlyMode,
  kRecord,
  kPlay,
  kPicture,
  kPictureWithText,
  kFinerError,
  kCoarserError,
  kPlainColors,
  kLevelColors,
  kErrorColors,
  kTriangles,
  kBoxes,
  kFreeze,
  kStatistics,
  kHelp,
  kQuit,
};

enum class Input { kKey, kHeldKey, kDrag, kDoubleClick, kWheel };

/// One row of the table of controls: what the window handles, the help overlay and docs/guide.md come from it.
struct Control {
  Action action;
  Input input;
  std::vector<int> codes;  ///< Keys or mouse buttons, as GLFW numbers them; each does it.
  std::string_view does;
  bool shift = false;  ///< Only with Shift; a row without goes without and, where no row wants it, with.
};

/// Controls that belong together.
struct ControlGroup {
  std::string_view title;
  std::vector<Control> controls;
};

std::span<const ControlGroup> control_groups();

/// What a key, button or the wheel (code 0) does.
std::optional<Action> action_of(Input input, int code, bool shift);

/// The keys held for an action of Input::kHeldKey.
std::span<const int> held_keys(Action action);

/// "W, up arrow", "left drag": what the user does for it.
std::string input_text(const Control& control);

/// The table as docs/guide.md has it.
std::string controls_as_markdown();

}  // namespace tintree::view
