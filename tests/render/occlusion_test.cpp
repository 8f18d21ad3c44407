#include "render/occlusion.h"

#include <cmath>
#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "render/lod_cut.h"
#include "tests/render/analytic_tree.h"

namespace tintree::render {
namespace {

/// Ridges and valleys as high as they are wide.
double hills(double x, double y) {
  return 160 * std::sin(x / 210) * std::cos(y / 170) + 60 * std::sin(x / 60 + y / 75);
}

class OcclusionTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { use(tree()); }

  static void use(const test::AnalyticTree& tree) {
    tree_ = tree;
    bounds_ = tree.bounds();
    occluders_.clear();
    for (const cache::TileNode& node : bounds_.nodes())
      occluders_.push_back(cache::make_occluder(tree.layout(), node.id, tree.mesh(node.id)));
  }

  static test::AnalyticTree tree() {
    test::AnalyticTree out;
    out.columns = 220;
    out.rows = 190;
    out.tile_cells = 16;
    out.height_m = hills;
    return out;
  }

  static Camera low(std::mt19937& random) {
    std::uniform_real_distribution<double> in(0, 1);
    Camera c;
    c.eye = {300 + 1600 * in(random), -300 - 1300 * in(random), 0};
    c.eye.z = hills(c.eye.x, c.eye.y) + 15 + 60 * in(random);
    const double turn = 6.283 * in(random);
    c.target = c.eye + glm::dvec3(std::sin(turn), std::cos(turn), 0.5 * in(random)-0.35);
    return c;
  }

  LodCut cut(const Camera& c, const IsResident& resident = kAll) const {
    return lod_cut(bounds_, c, {1}, resident, [](std::uint32_t, std::uint32_t node) { return &occluders_[node]; });
  }

  /// Height of the mesh of a tile at a place: the regular mesh of AnalyticTree.
  double height_m(const codec::TileId& id, double x, double y) const {
    const codec::TreeLayout l = tree_.layout();
    const codec::CellRect c = l.cells(id);
    const auto step = l.cells_across(id.level) / l.tile_cells;
    const auto [column, row] = l.grid(x, y);
    const auto begin = [&](double at, std::int64_t last) {
      return std::min(static_cast<std::int64_t>(at), last - 1) / step * step;
    };
    const std::int64_t x0 = begin(column, c.column1), y0 = begin(row, c.row1);
    const std::int64_t x1 = std::min(x0 + step, c.column1), y1 = std::min(y0 + step, c.row1);
    const double u = (column - static_cast<double>(x0)) / static_cast<double>(x1 - x0);
    const double v = (row - static_cast<double>(y0)) / static_cast<double>(y1 - y0);
    const auto at = [&](std::int64_t i, std::int64_t j) { return 0.0625 * static_cast<double>(tree_.steps(i, j)); };
    return u + v <= 1 ? at(x0, y0) + u * (at(x1, y0) - at(x0, y0)) + v * (at(x0, y1) - at(x0, y0))
                      : at(x1, y1) + (1 - u) * (at(x0, y1) - at(x1, y1)) + (1 - v) * (at(x1, y0) - at(x1, y1));
  }

  const codec::TileId& id(const DrawTile& d) const { return bounds_.nodes()[d.node].id; }

  /// The drawn tile at a place, or null.
  const codec::TileId* drawn_at(const LodCut& cut, double x, double y) const {
    const auto [column, row] = tree_.layout().grid(x, y);
    for (const DrawTile& d : cut.draws) {
      const codec::CellRect c = tree_.layout().cells(id(d));
      if (column >= static_cast<double>(c.column0) && column <= static_cast<double>(c.column1) &&
          row >= static_cast<double>(c.row0) && row <= static_cast<double>(c.row1)) {
        return &id(d);
      }
    }
    return nullptr;
  }

  /// Against brute force: on the way from the eye to any visible point of the ground that `all` draws and `some` leaves
  /// out, the ray passes under a tile that `some` draws.
  void expect_hidden(const LodCut& all, const LodCut& some, const Camera& c) const {
    const CameraAxes axes = c.axes();
    for (const DrawTile& d : all.draws) {
      const codec::TileMesh mesh = tree_.mesh(id(d));
      const codec::GridFrame frame(tree_.layout(), id(d), mesh);
      for (std::size_t i = 0; i < mesh.vertices.size(); i += 13) {
        const auto [x, y, z] = frame.world(mesh.vertices[i]);
        const glm::dvec3 way = glm::dvec3(x, y, z) - c.eye;
        const double depth = glm::dot(way, axes.forward);
        if (depth <= 0 || std::abs(glm::dot(way, axes.right)) > depth * c.tan_half_x() ||
            std::abs(glm::dot(way, axes.up)) > depth * c.tan_half_y() || drawn_at(some, x, y) != nullptr) {
          continue;
        }
        bool hidden = false;
        for (double share = 0.998; share > 0 && !hidden; share -= 0.002) {
          const glm::dvec3 p = c.eye + share * way;
          const codec::TileId* there = drawn_at(some, p.x, p.y);
          hidden = there != nullptr && p.z < height_m(*there, p.x, p.y);
        }
        ASSERT_TRUE(hidden) << "tile " << id(d).text();
      }
    }
  }

  inline static const IsResident kAll = [](std::uint32_t) { return true; };
  inline static test::AnalyticTree tree_;
  inline static cache::TileBounds bounds_;
  inline static std::vector<cache::Occluder> occluders_;
};

TEST_F(OcclusionTest, WhatIsLeftOutLiesBehindWhatIsDrawn) {
  std::mt19937 random(5);
  std::size_t without = 0, with = 0;
  for (int view = 0; view < 40; ++view) {
    const Camera c = low(random);
    const LodCut all = lod_cut(bounds_, c, {1}, kAll);
    const LodCut some = cut(c);
    without += all.draws.size();
    with += some.draws.size();
    expect_hidden(all, some, c);
  }
  EXPECT_LT(4 * with, 3 * without);  // It hides a good deal, or the test shows nothing.
}

TEST_F(OcclusionTest, AsksForNothingThatIsHidden) {
  std::mt19937 random(6);
  for (int view = 0; view < 20; ++view) {
    const Camera c = low(random);
    const LodCut full = cut(c);
    // What is drawn, loaded level by level as requests come, is all that is ever asked for at the end.
    std::set<std::uint32_t> here;
    for (const DrawTile& d : full.draws) here.insert(d.node);
    const LodCut again = cut(c, [&](std::uint32_t node) { return here.contains(node); });
    EXPECT_TRUE(again.complete) << view;
    EXPECT_TRUE(again.requests.empty()) << view;
    EXPECT_EQ(again.draws.size(), full.draws.size());
    EXPECT_EQ(again.occluded, full.occluded);
  }
}

// What a child hid must come back when a parent takes that child's place.
TEST_F(OcclusionTest, StandInsHideOnlyWhatTheyHideThemselves) {
  std::mt19937 random(8);
  int stood_in = 0;
  std::uint32_t occluded = 0;
  for (int view = 0; view < 40; ++view) {
    const Camera c = low(random);
    std::set<std::uint32_t> here{0};
    for (std::uint32_t i = 0; i < bounds_.nodes().size(); ++i) {
      if (random() % 8 != 0) here.insert(i);
    }
    const auto resident = [&](std::uint32_t node) { return here.contains(node); };
    const LodCut all = lod_cut(bounds_, c, {1}, resident);
    const LodCut some = cut(c, resident);
    for (const DrawTile& d : some.draws) {
      stood_in += d.stands_in ? 1 : 0;
      EXPECT_TRUE(here.contains(d.node));
    }
    occluded += some.occluded;
    EXPECT_LE(some.requests.size(), all.requests.size());
    expect_hidden(all, some, c);
  }
  EXPECT_GT(stood_in, 10);
  EXPECT_GT(occluded, 10U);
}

TEST_F(OcclusionTest, HidesNothingWhereThatCannotBeKnown) {
  std::mt19937 random(9);
  Camera c = low(random);
  c.target = c.eye + glm::dvec3(1, 0.2, -0.1);
  ASSERT_GT(cut(c).occluded, 0U);
  Camera under = c;
  under.eye.z -= 100;
  under.target.z -= 100;
  EXPECT_EQ(cut(under).occluded, 0U);
  Camera down = c;
  down.target = down.eye + glm::dvec3(0.1, 0, -1);
  EXPECT_EQ(cut(down).occluded, 0U);
  Camera beside = c;
  beside.eye.x = -50;
  beside.target = beside.eye + glm::dvec3(1, 0.2, -0.1);
  EXPECT_EQ(cut(beside).occluded, 0U);
  test::AnalyticTree holed = tree();
  holed.hole = [&](double x, double y) { return std::hypot(x - c.eye.x - 200, y - c.eye.y - 40) < 150; };
  use(holed);
  EXPECT_EQ(cut(c).occluded, 0U);
  use(tree());
}

TEST(OcclusionSwitch, RestsWhereItHidesLittle) {
  OcclusionSwitch s;
  int tried = 0;
  for (int frame = 0; frame < 160; ++frame) {
    tried += s.on(Occlusion::kWhereItPays) ? 1 : 0;
    EXPECT_TRUE(s.on(Occlusion::kAlways));
    EXPECT_FALSE(s.on(Occlusion::kOff));
    s.note_frame(100, 5);
  }
  EXPECT_EQ(tried, 10);
  while (!s.on(Occlusion::kWhereItPays)) s.note_frame(100, 0);
  for (int frame = 0; frame < 50; ++frame) {
    EXPECT_TRUE(s.on(Occlusion::kWhereItPays));
    s.note_frame(60, 40);
  }
}

}  // namespace
}  // namespace tintree::render
