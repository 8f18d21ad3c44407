#include "render/morph.h"

#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "render/lod_cut.h"
#include "tests/render/analytic_tree.h"

namespace tintree::render {
namespace {

const IsResident kAll = [](std::uint32_t) { return true; };

cache::TileBounds bounds(int levels_per_doubling = 1) {
  test::AnalyticTree tree;
  tree.columns = 200;
  tree.rows = 170;
  tree.tile_cells = 16;
  tree.levels_per_doubling = levels_per_doubling;
  return tree.bounds();
}

/// How many levels halve an error.
class MorphWeightTest : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(LevelsPerDoubling, MorphWeightTest, testing::Values(1, 2));

// A tile is its parent when the parent takes its place, and itself when its children take its own: in small steps of
// a flight a surface never jumps.
TEST_P(MorphWeightTest, IsContinuousWhereLevelsChange) {
  const cache::TileBounds b = bounds(GetParam());
  std::mt19937 random(2);
  std::uniform_real_distribution<double> in(0, 1);
  int merged = 0, split = 0;
  for (int flight = 0; flight < 12; ++flight) {
    Camera c;
    const glm::dvec3 begin(2000 * in(random), -1700 * in(random), 100 + 300 * in(random));
    const glm::dvec3 way(in(random)-0.5, in(random)-0.5, 1);
    std::map<std::uint32_t, double> before;
    for (int step = 0; step < 1500; ++step) {
      c.eye = begin + way * (4.0 * step);
      c.target = c.eye + glm::dvec3(0.3, 0.2, -1);
      const LodCut cut = lod_cut(b, c, {.pixel_error = 4, .morph = true}, kAll);
      std::map<std::uint32_t, double> now;
      const ScreenError screen_error(c);
      for (const DrawTile& d : cut.draws) {
        EXPECT_GE(d.morph, 0);
        EXPECT_LE(d.morph, 1);
        const cache::TileNode& node = b.nodes()[d.node];
        // Drawn only for the room that a morph takes: nothing is seen of its levels.
        if (!screen_error.bound_px(b.box(node), static_cast<double>(node.lod_error_m))) continue;
        now[d.node] = d.morph;
        EXPECT_TRUE(d.error_px <= 4 * 1.0001 || node.child_mask == 0) << node.id.text();
        if (const auto was = before.find(d.node); was != before.end()) {
          EXPECT_NEAR(d.morph, was->second, 0.12);
        }
        if (node.id.level == 0) continue;
        // Its parent was drawn before, or it was and the parent is now.
        const auto parent = static_cast<std::uint32_t>(b.find(b.layout().parent(node.id)));
        if (before.contains(parent)) {
          EXPECT_GT(d.morph, 0.88) << node.id.text();
          EXPECT_LT(before[parent], 0.12);
          ++split;
        }
      }
      for (const auto& [node, weight] : before) {
        const codec::TileId& id = b.nodes()[node].id;
        if (id.level == 0) continue;
        const auto parent = now.find(static_cast<std::uint32_t>(b.find(b.layout().parent(id))));
        if (parent == now.end()) continue;
        EXPECT_GT(weight, 0.88) << id.text();
        EXPECT_LT(parent->second, 0.12);
        ++merged;
      }
      before = std::move(now);
    }
  }
  EXPECT_GT(merged + split, 40);
}

TEST(MorphWeight, OffMeansNone) {
  const cache::TileBounds b = bounds();
  Camera c;
  c.eye = {900, -800, 700};
  c.target = {900, -500, 0};
  for (const DrawTile& d : lod_cut(b, c, {4}, kAll).draws) EXPECT_EQ(d.morph, 0);
  EXPECT_EQ(morph_weight(b, 0, ScreenError(c), 4), 0);
}

}  // namespace
}  // namespace tintree::render
