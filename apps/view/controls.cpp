#include "apps/view/controls.h"

#include <algorithm>
#include <array>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace tintree::view {
namespace {

using enum Action;
using enum Input;

std::vector<ControlGroup> make_groups() {
  return {
      {"Mouse",
       {{kOrbit,
         kDrag,
         {GLFW_MOUSE_BUTTON_LEFT},
         "orbit round the ground in the picture's middle; look round in fly mode"},
        {kLook, kDrag, {GLFW_MOUSE_BUTTON_LEFT}, "look round", true},
        {kPan, kDrag, {GLFW_MOUSE_BUTTON_RIGHT, GLFW_MOUSE_BUTTON_MIDDLE}, "move the ground under the cursor"},
        {kZoom, kWheel, {0}, "zoom to the cursor"},
        {kGoThere, kDoubleClick, {GLFW_MOUSE_BUTTON_LEFT}, "go there"}}},
      {"Moving (the speed grows with the height over the ground)",
       {{kAhead, kHeldKey, {GLFW_KEY_W, GLFW_KEY_UP}, "ahead"},
        {kBack, kHeldKey, {GLFW_KEY_S, GLFW_KEY_DOWN}, "back"},
        {kLeft, kHeldKey, {GLFW_KEY_A, GLFW_KEY_LEFT}, "left"},
        {kRight, kHeldKey, {GLFW_KEY_D, GLFW_KEY_RIGHT}, "right"},
        {kUp, kHeldKey, {GLFW_KEY_E, GLFW_KEY_PAGE_UP}, "up"},
        {kDown, kHeldKey, {GLFW_KEY_Q, GLFW_KEY_PAGE_DOWN}, "down"},
        {kFaster, kHeldKey, {GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT}, "five times as fast"},
        {kFlyMode, kKey, {GLFW_KEY_TAB}, "fly mode on and off: ahead is where you look"},
        {kLookThere, kKey, {GLFW_KEY_C}, "look at the ground under the cursor"},
        {kHome, kKey, {GLFW_KEY_HOME, GLFW_KEY_R}, "first view"}}},
      {"Pictures and flights",
       {{kPicture, kKey, {GLFW_KEY_F12}, "save tintree-NNN.png in the working directory"},
        {kPictureWithText, kKey, {GLFW_KEY_F12}, "the same with the text over it", true},
        {kRecord, kKey, {GLFW_KEY_F9}, "record a flight; again: save it as tintree-flight-NNN.json"},
        {kPlay, kKey, {GLFW_KEY_P}, "play the flight: the last one recorded, or --flight; again: stop"}}},
      {"What is shown",
       {{kFinerError, kKey, {GLFW_KEY_MINUS, GLFW_KEY_KP_SUBTRACT}, "smaller pixel error: finer tiles"},
        {kCoarserError, kKey, {GLFW_KEY_EQUAL, GLFW_KEY_KP_ADD}, "larger pixel error: coarser tiles"},
        {kSunEast, kHeldKey, {GLFW_KEY_L}, "turn the sun eastward, clockwise"},
        {kSunWest, kHeldKey, {GLFW_KEY_J}, "turn the sun the other way"},
        {kSunUp, kHeldKey, {GLFW_KEY_I}, "raise the sun"},
        {kSunDown, kHeldKey, {GLFW_KEY_K}, "lower the sun"},
        {kPlainColors, kKey, {GLFW_KEY_1}, "colours of the height"},
        {kLevelColors, kKey, {GLFW_KEY_2}, "colours of the levels"},
        {kErrorColors,
         kKey,
         {GLFW_KEY_3},
         "colours of the measured error: from blue, none, to yellow, all that is allowed"},
        {kTriangles, kKey, {GLFW_KEY_4, GLFW_KEY_F}, "triangles"},
        {kBoxes, kKey, {GLFW_KEY_5, GLFW_KEY_B}, "boxes of the tiles"},
        {kFreeze, kKey, {GLFW_KEY_6}, "freeze the tiles of this view, to look at them from elsewhere"},
        {kStatistics, kKey, {GLFW_KEY_T}, "figures on and off"},
        {kHelp, kKey, {GLFW_KEY_H, GLFW_KEY_F1}, "this help"},
        {kQuit, kKey, {GLFW_KEY_ESCAPE}, "quit"}}},
  };
}

struct Named {
  int code;
  std::string_view name;
};

std::string key_name(int code) {
  static constexpr std::array kNames{
      Named{GLFW_KEY_UP, "up arrow"},       Named{GLFW_KEY_DOWN, "down arrow"}, Named{GLFW_KEY_LEFT, "left arrow"},
      Named{GLFW_KEY_RIGHT, "right arrow"}, Named{GLFW_KEY_PAGE_UP, "Page Up"}, Named{GLFW_KEY_PAGE_DOWN, "Page Down"},
      Named{GLFW_KEY_LEFT_SHIFT, "Shift"},  Named{GLFW_KEY_RIGHT_SHIFT, ""},    Named{GLFW_KEY_TAB, "Tab"},
      Named{GLFW_KEY_HOME, "Home"},         Named{GLFW_KEY_ESCAPE, "Esc"},      Named{GLFW_KEY_EQUAL, "+"},
      Named{GLFW_KEY_KP_ADD, ""},           Named{GLFW_KEY_MINUS, "-"},         Named{GLFW_KEY_KP_SUBTRACT, ""}};
  const auto* const named = std::ranges::find(kNames, code, &Named::code);
  if (named != kNames.end()) return std::string(named->name);
  if (code >= GLFW_KEY_F1 && code <= GLFW_KEY_F25) return "F" + std::to_string(code - GLFW_KEY_F1 + 1);
  return {static_cast<char>(code)};  // Letters and digits have their own.
}

std::string button_name(int code) {
  return code == GLFW_MOUSE_BUTTON_LEFT ? "left" : code == GLFW_MOUSE_BUTTON_RIGHT ? "right" : "middle";
}

bool uses(const Control& control, int code) { return std::ranges::find(control.codes, code) != control.codes.end(); }

}  // namespace

std::span<const ControlGroup> control_groups() {
  static const std::vector<ControlGroup> kGroups = make_groups();
  return kGroups;
}

std::optional<Action> action_of(Input input, int code, bool shift) {
  std::optional<Action> found;
  for (const ControlGroup& group : control_groups()) {
    for (const Control& c : group.controls) {
      if (c.input != input || !uses(c, code) || (c.shift && !shift)) continue;
      if (c.shift || !found) found = c.action;
    }
  }
  return found;
}

std::span<const int> held_keys(Action action) {
  for (const ControlGroup& group : control_groups()) {
    const auto found = std::ranges::find(group.controls, action, &Control::action);
    if (found != group.controls.end()) return found->codes;
  }
  return {};
}

std::string input_text(const Control& control) {
  std::string out;
  for (const int code : control.codes) {
    const bool mouse = control.input == Input::kDrag || control.input == Input::kDoubleClick;
    const std::string name = mouse ? button_name(code) : control.input == Input::kWheel ? "wheel" : key_name(code);
    if (name.empty()) continue;
    out += (out.empty() ? "" : ", ") + name;
  }
  if (control.input == Input::kDrag) out += " drag";
  if (control.input == Input::kDoubleClick) out = "double-click";
  return control.shift ? "Shift + " + out : out;
}

std::string controls_as_markdown() {
  std::string out;
  for (const ControlGroup& group : control_groups()) {
    out += (out.empty() ? "| " : "\n| ") + std::string(group.title) + " | |\n|---|---|\n";
    for (const Control& c : group.controls) out += "| " + input_text(c) + " | " + std::string(c.does) + " |\n";
  }
  return out;
}

}  // namespace tintree::view
