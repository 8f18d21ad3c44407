#include "apps/view/controls.h"

#include <map>
#include <set>
#include <tuple>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include "apps/view/hud.h"
#include "render/font.h"
#include "tests/support/temp_dir.h"

namespace tintree::view {
namespace {

std::vector<Control> all() {
  std::vector<Control> out;
  for (const ControlGroup& group : control_groups())
    out.insert(out.end(), group.controls.begin(), group.controls.end());
  return out;
}

TEST(Controls, EveryActionHasOneRow) {
  std::set<Action> seen;
  for (const Control& c : all()) EXPECT_TRUE(seen.insert(c.action).second) << c.does;
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(Action::kQuit) + 1);
}

TEST(Controls, NoKeyMeansTwoThings) {
  std::set<std::tuple<Input, int, bool>> seen;
  std::set<int> keys;
  for (const Control& c : all()) {
    for (const int code : c.codes) {
      EXPECT_TRUE(seen.insert({c.input, code, c.shift}).second) << input_text(c);
      EXPECT_TRUE(c.input != Input::kHeldKey || keys.insert(code).second) << input_text(c);
    }
  }
  for (const Control& c : all()) {
    for (const int code : c.codes) EXPECT_TRUE(c.input != Input::kKey || !keys.contains(code)) << input_text(c);
  }
}

TEST(Controls, EachDoesWhatItsRowSays) {
  for (const Control& c : all()) {
    for (const int code : c.codes) EXPECT_EQ(action_of(c.input, code, c.shift), c.action) << input_text(c);
    EXPECT_FALSE(input_text(c).empty());
  }
  EXPECT_EQ(action_of(Input::kKey, GLFW_KEY_HOME, true), Action::kHome) << "Shift alone changes nothing";
  EXPECT_EQ(action_of(Input::kKey, GLFW_KEY_F12, true), Action::kPictureWithText);
  EXPECT_EQ(action_of(Input::kKey, GLFW_KEY_Y, false), std::nullopt);
}

TEST(Controls, TheGuideHasThisTable) {
  const std::string guide = test::read_file(TINTREE_SOURCE_DIR "/docs/guide.md");
  EXPECT_NE(guide.find(controls_as_markdown()), std::string::npos) << "docs/guide.md wants this table:\n\n"
                                                                   << controls_as_markdown();
}

TEST(Controls, TheHelpFitsAndNamesEveryOne) {
  HudText text;
  text.help = true;
  for (const auto& [width, height] : {std::pair(1280, 720), std::pair(800, 500)}) {
    const Hud hud = lay_out(text, width, height, 1);
    std::multiset<std::string> shown;
    for (const render::TextLine& line : hud.lines) {
      shown.insert(line.text);
      const float right =
          line.at_px.x + render::character_px(hud.size_px).x * static_cast<float>(render::character_count(line.text));
      EXPECT_GE(line.at_px.x, 0);
      EXPECT_LE(right, static_cast<float>(width));
      EXPECT_GE(line.at_px.y, 0);
      EXPECT_LE(line.at_px.y + render::character_px(hud.size_px).y, static_cast<float>(height));
    }
    for (const Control& c : all()) {
      EXPECT_TRUE(shown.contains(input_text(c)));
      EXPECT_TRUE(shown.contains(std::string(c.does)));
    }
  }
}

TEST(Hud, WrapsAtTheBreaks) {
  const std::vector<std::string> parts{"12 fps", "3 ms", "4 triangles"};
  EXPECT_EQ(wrap(parts, 100), std::vector<std::string>{"12 fps · 3 ms · 4 triangles"});
  EXPECT_EQ(wrap(parts, 14), (std::vector<std::string>{"12 fps · 3 ms", "4 triangles"}));
  EXPECT_EQ(wrap(parts, 1), parts);
  EXPECT_TRUE(wrap({}, 10).empty());
}

TEST(Hud, GrowsWithTheScreensScale) {
  HudText text;
  text.place = "x 1 y 2";
  EXPECT_FLOAT_EQ(lay_out(text, 2000, 1000, 2).size_px, 2 * lay_out(text, 1000, 500, 1).size_px);
  EXPECT_TRUE(lay_out({}, 1000, 500, 1).lines.empty());
  EXPECT_TRUE(lay_out({}, 1000, 500, 1).panels.empty());
}

}  // namespace
}  // namespace tintree::view
