// Text and lines over a picture, under OSMesa.
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "render/font.h"
#include "render/frozen_cut.h"
#include "render/frustum.h"
#include "render/line_drawer.h"
#include "render/offscreen_target.h"
#include "render/text_drawer.h"
#include "render/tile_tint.h"
#include "tests/render/osmesa_test.h"
#include "tests/render/analytic_tree.h"

namespace tintree::render {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 120;

TEST(Font, EveryCharacterIsItsOwn) {
  const Font& font = overlay_font();
  ASSERT_EQ(font.distances.size(), static_cast<std::size_t>(font.columns * font.cell_px[0]) *
                                       static_cast<std::size_t>(font.rows * font.cell_px[1]));
  std::set<std::string> seen;
  for (int i = 0; i < static_cast<int>(kFontCharacters.size()); ++i) {
    std::string cell;
    int inside = 0;
    for (int y = 0; y < font.cell_px[1]; ++y) {
      for (int x = 0; x < font.cell_px[0]; ++x) {
        const int row = i / font.columns * font.cell_px[1] + y;
        const int column = i % font.columns * font.cell_px[0] + x;
        const int value = font.distances[static_cast<std::size_t>(row * font.columns * font.cell_px[0] + column)];
        cell.push_back(static_cast<char>(value));
        if (value > 128) ++inside;
        const bool rim = x == 0 || y == 0 || x + 1 == font.cell_px[0] || y + 1 == font.cell_px[1];
        EXPECT_FALSE(rim && value >= 128) << "no character reaches its cell's rim: " << i;
      }
    }
    EXPECT_EQ(inside == 0, i == 0) << i;
    EXPECT_TRUE(seen.insert(cell).second) << i;
  }
}

TEST(Font, ReadsUtf8AndKeepsToTheEnd) {
  std::string_view text = "a°×\xe2\x82\xac";
  EXPECT_EQ(kFontCharacters[take_character(text)], U'a');
  EXPECT_EQ(kFontCharacters[take_character(text)], U'°');
  EXPECT_EQ(kFontCharacters[take_character(text)], U'×');
  EXPECT_EQ(take_character(text), kFontCharacters.size() - 1) << "the euro sign is not there";
  EXPECT_TRUE(text.empty());
  EXPECT_EQ(character_count("36°N \xe2\x82"), 6U) << "a text that was cut off inside a character";
}

class Overlay : public OsMesaTest {
 protected:
  void SetUp() override {
    target_.emplace(std::move(*OffscreenTarget::create(gl_, kWidth, kHeight, 4)));
    target_->bind();
    gl_.DepthMask(GL_TRUE);
    gl_.ClearColor(0, 0, 0, 1);
    gl_.ClearDepth(0);
    gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  }

  std::optional<OffscreenTarget> target_;
};

TEST_F(Overlay, PanelsCoverTheirAreaAndMix) {
  const auto text = TextDrawer::create(gl_);
  ASSERT_TRUE(text) << text.error().text();
  const TextPanel panel{{20, 30}, {60, 50}, {1, 1, 1, 0.5F}};
  text->draw({kWidth, kHeight}, {&panel, 1}, {}, 16);
  const Picture picture = target_->read_picture();
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool inside = x >= 20 && x < 60 && y >= 30 && y < 50;
      ASSERT_NEAR(picture.at(x, y)[1], inside ? 128 : 0, 1) << x << ' ' << y;
    }
  }
  EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
}

TEST_F(Overlay, TextStandsWhereItShould) {
  const auto text = TextDrawer::create(gl_);
  ASSERT_TRUE(text) << text.error().text();
  // An l is a stem: upright, as high as the ascent. Text at twice the size is twice as far across.
  for (const float size : {12.0F, 24.0F}) {
    SetUp();
    const std::vector<TextLine> lines{{{10, 10}, "   l", {1, 1, 1, 1}}};
    text->draw({kWidth, kHeight}, {}, lines, size);
    const Picture picture = target_->read_picture();
    const glm::vec2 character = character_px(size);
    double sum = 0, mean_x = 0, top = kHeight, bottom = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double value = picture.at(x, y)[0] / 255.0;
        sum += value, mean_x += value * (x + 0.5);
        if (value > 0.5) top = std::min(top, y + 0.0), bottom = std::max(bottom, y + 1.0);
      }
    }
    ASSERT_GT(sum, 0);
    EXPECT_NEAR(mean_x / sum, 10 + 3.5 * character.x, 0.15 * character.x);
    EXPECT_NEAR(bottom - top, 0.76 * size, 1.5);  // DejaVu's ascender.
    EXPECT_GT(top, 10);
    EXPECT_LT(bottom, 10 + character.y);
  }
}

TEST_F(Overlay, LinesHideBehindTheGroundAndLeaveItsDepth) {
  const auto lines = LineDrawer::create(gl_);
  ASSERT_TRUE(lines) << lines.error().text();
  Camera camera;
  camera.eye = {0, 0, 0};
  camera.target = {0, 1, 0};
  camera.width_px = kWidth;
  camera.height_px = kHeight;
  // The "ground": all of the frame at depth 100 with near_m 1.
  target_->bind();
  gl_.ClearDepth(0.01);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  // Through the middles of a row of pixels each.
  const double up = 2 * camera.tan_half_y() / kHeight;
  const WorldLine front{{-500, 50, 10.5 * up * 50}, {500, 50, 10.5 * up * 50}, {1, 0, 0, 1}};
  const WorldLine behind{{-500, 200, -10.5 * up * 200}, {500, 200, -10.5 * up * 200}, {0, 1, 0, 1}};
  const std::vector<WorldLine> both{front, behind};
  lines->draw(*target_, camera, 1, both);
  const Picture picture = target_->read_picture();
  int red = 0, green = 0;
  for (int y = 0; y < kHeight; ++y) {
    red += picture.at(kWidth / 2, y)[0];
    green += picture.at(kWidth / 2, y)[1];
  }
  EXPECT_GT(red, 150);
  EXPECT_EQ(green, 0);
  EXPECT_GT(picture.at(kWidth / 2, kHeight / 2 - 11)[0], 100);
  EXPECT_FLOAT_EQ(target_->read_depth(kWidth / 2, kHeight / 2 - 11), 0.01F);
}

TEST(WorldLines, ABoxHasTwelveEdges) {
  std::vector<WorldLine> lines;
  add_box(lines, {{0, 0, 0}, {1, 2, 4}}, {1, 1, 1, 1});
  ASSERT_EQ(lines.size(), 12U);
  double length = 0;
  for (const WorldLine& line : lines) length += glm::distance(line.from, line.to);
  EXPECT_DOUBLE_EQ(length, 4 * (1 + 2 + 4));
}

TEST(WorldLines, AViewReachesItsDepth) {
  Camera camera;
  camera.eye = {10, 20, 30};
  camera.target = {400, 500, -20};
  std::vector<WorldLine> lines;
  add_view(lines, camera, 70, {1, 1, 1, 1});
  ASSERT_EQ(lines.size(), 8U);
  for (const WorldLine& line : lines) EXPECT_NEAR(glm::dot(line.to - camera.eye, camera.axes().forward), 70, 1e-9);
}

TEST(TileTints, TellLevelsAndErrorsApart) {
  cache::TileNode node;
  DrawTile drawn;
  EXPECT_EQ(tile_tint(Tint::kHeight, node, drawn, 1).a, 0);
  const glm::vec4 root = tile_tint(Tint::kLevel, node, drawn, 1);
  node.id.level = 1;
  EXPECT_GT(glm::distance(tile_tint(Tint::kLevel, node, drawn, 1), root), 0.1);
  // Error colours follow the share of what is allowed; more than that is its own colour.
  drawn.error_px = 1;
  const glm::vec4 half = tile_tint(Tint::kError, node, drawn, 2);
  drawn.error_px = 2;
  EXPECT_EQ(tile_tint(Tint::kError, node, drawn, 4), half);
  EXPECT_GT(half.g, half.b);
  drawn.error_px = 2.001;
  const glm::vec4 more = tile_tint(Tint::kError, node, drawn, 2);
  EXPECT_GT(more.r, 2 * more.g);
}

// Drawn from elsewhere, nothing of a frozen cut may fall in front of the nearest plane.
TEST(FrozenCut, TakesDepthsFromTheNewCamera) {
  const test::AnalyticTree tree;
  const cache::TileBounds bounds = tree.bounds();
  const cache::TileBounds* const at = &bounds;
  const Trees trees(&at, 1);
  Camera chosen;
  chosen.eye = {640, -4000, 3000};
  chosen.target = {640, -640, 0};
  const LodCut cut = lod_cut(bounds, chosen, {}, [](std::uint32_t) { return true; });
  Camera near = chosen;
  near.eye = {640, -1500, 300};
  const LodCut seen = seen_from(cut, trees, near);
  ASSERT_EQ(seen.draws.size(), cut.draws.size());
  EXPECT_LT(seen.nearest_m, cut.nearest_m);
  for (std::size_t i = 0; i < cut.draws.size(); ++i) {
    EXPECT_EQ(seen.draws[i].node, cut.draws[i].node);
    EXPECT_EQ(seen.draws[i].error_px, cut.draws[i].error_px);
    const cache::Box box = bounds.box(bounds.nodes()[cut.draws[i].node]);
    const glm::dvec3 middle(0.5 * (box.min[0] + box.max[0]), 0.5 * (box.min[1] + box.max[1]), box.min[2]);
    const double depth = glm::dot(middle - near.eye, near.axes().forward);
    EXPECT_TRUE(Frustum(near).outside(box) || seen.nearest_m <= depth);
    EXPECT_GE(seen.draws[i].farthest_m, depth);
  }
  Camera away = near;
  away.target = near.eye + glm::dvec3(0, -1000, 0);
  EXPECT_EQ(seen_from(cut, trees, away).nearest_m, 0);
}

}  // namespace
}  // namespace tintree::render
