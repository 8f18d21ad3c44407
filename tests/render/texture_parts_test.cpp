#include "render/texture_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <span>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "tests/render/analytic_tree.h"

namespace tintree::render {
namespace {

using codec::TileId;

constexpr int kDepth = 3;

class TexturePartsTest : public testing::TestWithParam<int> {
 protected:
  TexturePartsTest() {
    tree_.columns = 150;  // The tiles of the east and south are cut short.
    tree_.rows = 110;
    tree_.tile_cells = 16;
    tree_.levels_per_doubling = GetParam();
    tree_.texture_depth = kDepth;
    bounds_ = tree_.bounds();
    bounds_.set_textures(16, kDepth);
  }

  static Camera camera(std::mt19937& random) {
    std::uniform_real_distribution<double> in(0, 1);
    Camera c;
    c.eye = {1500 * in(random), -1100 * in(random), 100 + 6000 * std::pow(in(random), 2)};
    c.target = {1500 * in(random), -1100 * in(random), 0};
    return c;
  }

  /// A cut with all tiles there.
  LodCut divided(const Camera& c, const TextureStates& state) const {
    const std::array<const cache::TileBounds*, 1> trees{&bounds_};
    LodCut cut = lod_cut(bounds_, c, {}, [](std::uint32_t) { return true; });
    add_texture_parts(cut, trees, c, state);
    return cut;
  }

  /// Pixels that the side of a leaf's texels, halved so often, takes at most: by its distance, whichever way it faces.
  double texel_px(const Camera& c, int depth, const glm::dvec3& at) const {
    const double texel_m = 16 * tree_.spacing_m / 16 / (1 << depth);
    return texel_m * c.focal_px() / glm::dot(at - c.eye, c.axes().forward);
  }

  static bool sees(const Camera& c, const glm::dvec3& at) {
    const glm::dvec3 way = at - c.eye;
    const CameraAxes axes = c.axes();
    const double depth = glm::dot(way, axes.forward);
    return depth > 1 && std::abs(glm::dot(way, axes.right)) < c.tan_half_x() * depth &&
           std::abs(glm::dot(way, axes.up)) < c.tan_half_y() * depth;
  }

  /// The finest part of a leaf at a place on the grid: how often the leaf is halved for it.
  int depth_at(const LodCut& cut, const DrawTile& d, double column, double row) const {
    const TileId& leaf = bounds_.nodes()[d.node].id;
    int out = 0;
    for (const TexturePart& p : std::span(cut.parts).subspan(d.first_part, d.parts)) {
      const double side = 16.0 / (1 << p.depth);
      const bool inside = std::floor(column / side) == leaf.x * (1U << p.depth) + p.x &&
                          std::floor(row / side) == leaf.y * (1U << p.depth) + p.y;
      EXPECT_TRUE(!inside || p.depth > out) << "a coarser one comes later";
      if (inside) out = p.depth;
    }
    return out;
  }

  test::AnalyticTree tree_;
  cache::TileBounds bounds_;
};

// Points of the ground in view: with all textures there, what lies on them is as fine as it should be.
TEST_P(TexturePartsTest, EveryPointInViewHasOneFineEnough) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> in(0, 1);
  std::array<int, kDepth + 1> seen{};
  const codec::TreeLayout squares = tree_.squares();
  for (int round = 0; round < 40; ++round) {
    const Camera c = camera(random);
    const LodCut cut = divided(c, [](const cache::TileRef&) { return TextureState::kResident; });
    EXPECT_TRUE(cut.complete && cut.requests.empty());
    std::set<int> rows;
    for (const DrawTile& d : cut.draws) {
      EXPECT_EQ(d.part_row >= 0, d.parts > 0);
      if (d.parts == 0) continue;
      EXPECT_TRUE(rows.insert(d.part_row).second);
      const cache::TileNode& node = bounds_.nodes()[d.node];
      EXPECT_TRUE(bounds_.layout().is_leaf_square(node.id.level));
      for (const TexturePart& p : std::span(cut.parts).subspan(d.first_part, d.parts)) {
        TileId round_it = p.texture;
        EXPECT_FALSE(squares.cells(p.texture).empty());
        EXPECT_EQ(squares.picture_tile(p.texture), p.texture);
        while (round_it.level > node.id.level) round_it = squares.parent(round_it);
        EXPECT_EQ(round_it, node.id);
      }
      const cache::Box box = bounds_.box(node);
      for (int i = 0; i < 50; ++i) {
        const glm::dvec3 at(std::lerp(box.min[0], box.max[0], in(random)),
                            std::lerp(box.min[1], box.max[1], in(random)), box.max[2]);
        if (!sees(c, at)) continue;
        const int depth = depth_at(cut, d, at.x / tree_.spacing_m, -at.y / tree_.spacing_m);
        EXPECT_TRUE(depth == kDepth || texel_px(c, depth, at) <= 1 + 1e-9) << depth;
        ++seen[static_cast<std::size_t>(depth)];
      }
    }
    EXPECT_EQ(rows.size(), rows.empty() ? 0U : static_cast<std::size_t>(*rows.rbegin()) + 1);
  }
  for (const int count : std::span(seen).subspan(1)) EXPECT_GT(count, 30);
}

// What is missing is asked for once what lies round it is there, and nothing lies on its square.
TEST_P(TexturePartsTest, CoarserOnesComeFirst) {
  std::mt19937 random(6);
  const codec::TreeLayout squares = tree_.squares();
  int asked = 0;
  for (int round = 0; round < 40; ++round) {
    const auto state = [&](const cache::TileRef& t) {
      const auto dice = static_cast<std::size_t>(t.id.key()) * 0x9E3779B97F4A7C15U >> 60;
      return dice < 4 ? TextureState::kMissing : dice < 6 ? TextureState::kNone : TextureState::kResident;
    };
    const LodCut cut = divided(camera(random), state);
    EXPECT_EQ(cut.complete, cut.requests.empty());
    for (const TexturePart& p : cut.parts) EXPECT_EQ(state({p.texture, 0}), TextureState::kResident);
    int level = 0;
    for (const cache::TileRef& t : cut.requests) {
      ++asked;
      EXPECT_EQ(state(t), TextureState::kMissing) << t.id.text();
      EXPECT_GE(t.id.level, std::exchange(level, t.id.level));
      TileId id = t.id;
      while (id.level > squares.coarsest_level(squares.halvings(bounds_.layout().leaf_level) + 1)) {
        id = squares.picture_tile(squares.parent(id));
        EXPECT_EQ(state({id, 0}), TextureState::kResident) << id.text();
      }
    }
  }
  EXPECT_GT(asked, 100);
}

TEST_P(TexturePartsTest, DamagedOnesHideNothingBelow) {
  std::mt19937 random(7);
  int finest = 0;
  for (int round = 0; round < 20; ++round) {
    const int first = bounds_.layout().coarsest_level(bounds_.layout().halvings(bounds_.layout().leaf_level) + 1);
    const LodCut cut = divided(camera(random), [&](const cache::TileRef& t) {
      return t.id.level == first ? TextureState::kLost : TextureState::kResident;
    });
    EXPECT_TRUE(cut.requests.empty());
    for (const TexturePart& p : cut.parts) {
      EXPECT_GT(p.depth, 1);
      finest += p.depth == kDepth ? 1 : 0;
    }
  }
  EXPECT_GT(finest, 10);
}

TEST_P(TexturePartsTest, AFarViewNeedsNone) {
  Camera c;
  c.eye = {750, -550, 100000};
  c.target = {750, -549, 0};
  const LodCut cut = divided(c, [](const cache::TileRef& t) {
    ADD_FAILURE() << t.id.text();
    return TextureState::kResident;
  });
  EXPECT_TRUE(cut.parts.empty());
  EXPECT_TRUE(cut.complete);
}

INSTANTIATE_TEST_SUITE_P(LevelsPerDoubling, TexturePartsTest, testing::Values(1, 2));

}  // namespace
}  // namespace tintree::render
