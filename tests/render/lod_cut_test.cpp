#include "render/lod_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "render/screen_error.h"
#include "tests/render/analytic_tree.h"

namespace tintree::render {
namespace {

using cache::TileRef;
using codec::TileId;

/// Over trees of one and of two levels a doubling.
class LodCutTest : public testing::TestWithParam<int> {
 protected:
  static cache::TileBounds make_bounds(int levels_per_doubling) {
    test::AnalyticTree tree;
    tree.columns = 300;  // Odd sizes: the tiles of the east and south are cut short.
    tree.rows = 211;
    tree.tile_cells = 16;
    tree.levels_per_doubling = levels_per_doubling;
    return tree.bounds();
  }
  static const cache::TileBounds& bounds_of(int levels_per_doubling) {
    static const std::array<cache::TileBounds, 2> all{make_bounds(1), make_bounds(2)};
    return all[static_cast<std::size_t>(levels_per_doubling - 1)];
  }

  static Camera camera(std::mt19937& random) {
    std::uniform_real_distribution<double> in(0, 1);
    Camera c;
    c.eye = {3000 * in(random), -2100 * in(random), 30 + 40000 * std::pow(in(random), 4)};
    c.target = {3000 * in(random), -2100 * in(random), 40 * in(random)};
    return c;
  }

  bool covers(const TileId& a, const TileId& b) const {
    if (a.level > b.level) return false;
    const int depth = bounds_.layout().halvings(b.level) - bounds_.layout().halvings(a.level);
    return b.x >> depth == a.x && b.y >> depth == a.y;
  }

  const TileId& id(const DrawTile& d) const { return bounds_.nodes()[d.node].id; }

  /// Whether a point of the box, of a few hundred, is in the picture.
  static bool sees(const Camera& c, const cache::Box& box) {
    constexpr int kSteps = 8;
    const CameraAxes axes = c.axes();
    for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
      const std::array<int, 3> at{i % kSteps, i / kSteps % kSteps, i / kSteps / kSteps};
      glm::dvec3 way = -c.eye;
      for (int k = 0; k < 3; ++k) {
        const auto axis = static_cast<std::size_t>(k);
        way[k] += std::lerp(box.min[axis], box.max[axis], at[axis] / (kSteps - 1.0));
      }
      const double depth = glm::dot(way, axes.forward);
      if (depth > 0 && std::abs(glm::dot(way, axes.right)) <= c.tan_half_x() * depth &&
          std::abs(glm::dot(way, axes.up)) <= c.tan_half_y() * depth)
        return true;
    }
    return false;
  }

  /// How often each leaf is drawn; checks that it is once where it must be.
  void expect_covered_once(const LodCut& cut, const Camera& c) const {
    for (const cache::TileNode& node : bounds_.nodes()) {
      if (node.child_mask != 0) continue;
      const auto times = std::ranges::count_if(cut.draws, [&](const DrawTile& d) { return covers(id(d), node.id); });
      EXPECT_LE(times, 1) << node.id.text();
      EXPECT_TRUE(times == 1 || !sees(c, bounds_.box(node))) << node.id.text();
    }
  }

  const cache::TileBounds& bounds_ = bounds_of(GetParam());
};

INSTANTIATE_TEST_SUITE_P(LevelsPerDoubling, LodCutTest, testing::Values(1, 2));

const IsResident kAll = [](std::uint32_t) { return true; };

TEST_P(LodCutTest, CoversWhatIsVisibleExactlyOnceWithinTheError) {
  std::mt19937 random(1);
  std::set<int> levels;
  for (int i = 0; i < 60; ++i) {
    const Camera c = camera(random);
    const LodCut cut = lod_cut(bounds_, c, {1}, kAll);
    EXPECT_TRUE(cut.complete);
    EXPECT_TRUE(cut.requests.empty());
    EXPECT_EQ(cut.wanted, cut.draws.size());
    EXPECT_EQ(cut.late, 0U);
    expect_covered_once(cut, c);
    for (const DrawTile& d : cut.draws) {
      const cache::TileNode& node = bounds_.nodes()[d.node];
      levels.insert(node.id.level);
      EXPECT_FALSE(d.stands_in);
      EXPECT_TRUE(d.error_px <= 1 || node.child_mask == 0) << node.id.text();
      EXPECT_EQ(d.error_px, ScreenError(c).bound_px(bounds_.box(node), static_cast<double>(node.lod_error_m)));
      EXPECT_LE(d.error_px, cut.max_error_px);
    }
  }
  EXPECT_GE(levels.size(), 3U);  // The test is one of several levels at once.
}

TEST_P(LodCutTest, IsTheCoarsestSuchCut) {
  std::mt19937 random(2);
  for (int i = 0; i < 30; ++i) {
    const Camera c = camera(random);
    const ScreenError screen_error(c);
    for (const DrawTile& d : lod_cut(bounds_, c, {1}, kAll).draws) {
      if (id(d).level == 0) continue;
      const cache::TileNode& parent =
          bounds_.nodes()[static_cast<std::size_t>(bounds_.find(bounds_.layout().parent(id(d))))];
      EXPECT_GT(screen_error.bound_px(bounds_.box(parent), static_cast<double>(parent.lod_error_m)), 1);
    }
  }
}

TEST_P(LodCutTest, AMorePatientEyeNeedsFewerTiles) {
  std::mt19937 random(3);
  const Camera c = camera(random);
  EXPECT_GE(lod_cut(bounds_, c, {0.5}, kAll).draws.size(), lod_cut(bounds_, c, {4}, kAll).draws.size());
  for (const DrawTile& d : lod_cut(bounds_, c, {0}, kAll).draws) EXPECT_EQ(bounds_.nodes()[d.node].child_mask, 0);
}

TEST_P(LodCutTest, DrawsFrontToBack) {
  std::mt19937 random(4);
  for (int i = 0; i < 30; ++i) {
    const Camera c = camera(random);
    const LodCut cut = lod_cut(bounds_, c, {1}, kAll);
    // A tile is in front of another where a line parallel to an axis or one that both share separates them:
    // no later tile may lie on the eye's side of such a line while the earlier lies beyond it.
    for (std::size_t a = 0; a < cut.draws.size(); ++a) {
      const cache::Box first = bounds_.box(bounds_.nodes()[cut.draws[a].node]);
      for (std::size_t b = a + 1; b < cut.draws.size(); ++b) {
        const cache::Box later = bounds_.box(bounds_.nodes()[cut.draws[b].node]);
        const bool hides = [&] {
          bool nearer = true;
          bool apart = false;
          for (std::size_t axis = 0; axis < 2; ++axis) {
            const double eye = c.eye[static_cast<int>(axis)];
            if (later.max[axis] <= first.min[axis]) {
              apart = true;
              nearer = nearer && eye <= later.max[axis];
            } else if (later.min[axis] >= first.max[axis]) {
              apart = true;
              nearer = nearer && eye >= later.min[axis];
            }
          }
          return apart && nearer;
        }();
        EXPECT_FALSE(hides);
      }
    }
  }
}

TEST_P(LodCutTest, WithNothingResidentAsksCoarseFirstAndDrawsNothing) {
  std::mt19937 random(5);
  const LodCut cut = lod_cut(bounds_, camera(random), {1}, [](std::uint32_t) { return false; });
  EXPECT_TRUE(cut.draws.empty());
  EXPECT_FALSE(cut.complete);
  ASSERT_FALSE(cut.requests.empty());
  EXPECT_EQ(cut.requests.front().id, (TileId{0, 0, 0}));
  EXPECT_TRUE(std::ranges::is_sorted(cut.requests, {}, [](const TileRef& r) { return r.id.level; }));
  EXPECT_EQ(cut.late, cut.wanted);
  EXPECT_GT(cut.late, 0U);
}

// Of one level the tiles in the middle of the view come first.
TEST_P(LodCutTest, AsksForTheMiddleOfTheViewFirst) {
  std::mt19937 random(7);
  int compared = 0;
  for (int i = 0; i < 20; ++i) {
    const Camera c = camera(random);
    const LodCut cut = lod_cut(bounds_, c, {1}, [](std::uint32_t n) { return n == 0; });
    const auto angle = [&](const TileRef& t) {
      const cache::Box b = bounds_.box(bounds_.nodes()[static_cast<std::size_t>(bounds_.find(t.id))]);
      const glm::dvec3 middle{(b.min[0] + b.max[0]) / 2, (b.min[1] + b.max[1]) / 2, (b.min[2] + b.max[2]) / 2};
      const glm::dvec3 way = glm::normalize(middle - c.eye);
      return std::acos(std::clamp(glm::dot(way, glm::normalize(c.target - c.eye)), -1.0, 1.0));
    };
    for (std::size_t k = 1; k < cut.requests.size(); ++k) {
      if (cut.requests[k].id.level != cut.requests[k - 1].id.level) continue;
      EXPECT_LE(angle(cut.requests[k - 1]), angle(cut.requests[k]) + 1e-6);
      ++compared;
    }
  }
  EXPECT_GT(compared, 50);
}

// Whatever subset is resident: once the root is there, nothing visible is missing, nothing is drawn twice,
// only resident tiles are drawn, and fetching what is asked for ends in the one complete cut.
TEST_P(LodCutTest, ParentsStandInUntilTheirChildrenHaveCome) {
  std::mt19937 random(6);
  for (int i = 0; i < 40 / GetParam() / GetParam(); ++i) {  // Twice the levels take four times as long.
    const Camera c = camera(random);
    std::set<std::uint32_t> here{0};
    for (std::uint32_t n = 0; n < bounds_.nodes().size(); ++n) {
      if (random() % 3 == 0) here.insert(n);
    }
    const IsResident resident = [&](std::uint32_t n) { return here.contains(n); };
    for (int round = 0;; ++round) {
      ASSERT_LT(round, 1000);
      const LodCut cut = lod_cut(bounds_, c, {1}, resident);
      expect_covered_once(cut, c);
      for (const DrawTile& d : cut.draws) EXPECT_TRUE(resident(d.node));
      if (cut.complete) break;
      ASSERT_FALSE(cut.requests.empty());
      for (const TileRef& r : cut.requests) EXPECT_FALSE(resident(static_cast<std::uint32_t>(bounds_.find(r.id))));
      here.insert(static_cast<std::uint32_t>(bounds_.find(cut.requests.front().id)));
    }
    const LodCut with_some = lod_cut(bounds_, c, {1}, resident);
    const LodCut with_all = lod_cut(bounds_, c, {1}, kAll);
    ASSERT_EQ(with_some.draws.size(), with_all.draws.size());
    for (std::size_t k = 0; k < with_all.draws.size(); ++k) EXPECT_EQ(with_some.draws[k].node, with_all.draws[k].node);
  }
}

TEST_P(LodCutTest, FinerTilesStandInForACoarseOneThatIsMissing) {
  Camera far;
  far.eye = {1500, -1000, 5e6};
  far.target = {1500, -1000, 0};
  ASSERT_EQ(lod_cut(bounds_, far, {1}, kAll).draws.size(), 1U);
  const LodCut cut = lod_cut(bounds_, far, {1}, [](std::uint32_t n) { return n != 0; });
  EXPECT_FALSE(cut.complete);
  EXPECT_EQ(cut.requests, std::vector<TileRef>(1, TileRef{{0, 0, 0}}));
  expect_covered_once(cut, far);
}

// Whatever is lost, all else is drawn as soon as it is there: a lost tile has a hole only where it and all above
// it are lost, and nothing waits for what never comes.
TEST_P(LodCutTest, GoesRoundWhatIsLost) {
  std::mt19937 random(8);
  const std::array<const cache::TileBounds*, 1> trees{&bounds_};
  for (int i = 0; i < 40; ++i) {
    const Camera c = camera(random);
    std::set<std::uint32_t> lost;
    for (std::uint32_t n = i % 2; n < bounds_.nodes().size(); ++n) {
      if (random() % 8 == 0) lost.insert(n);
    }
    if (i % 4 == 0) lost.insert(0);
    const LodCut cut = lod_cut(trees, c, {1}, [&](std::uint32_t, std::uint32_t n) {
      return lost.contains(n) ? TileState::kLost : TileState::kResident;
    });
    EXPECT_EQ(cut.late, 0U);
    for (const cache::TileNode& node : bounds_.nodes()) {
      if (node.child_mask != 0 || !sees(c, bounds_.box(node))) continue;
      const auto times = std::ranges::count_if(cut.draws, [&](const DrawTile& d) { return covers(id(d), node.id); });
      bool forsaken = true;
      for (TileId t = node.id;; t = bounds_.layout().parent(t)) {
        forsaken = forsaken && lost.contains(static_cast<std::uint32_t>(bounds_.find(t)));
        if (t.level == 0) break;
      }
      if (forsaken) {
        EXPECT_EQ(times, 0);
      } else {
        EXPECT_EQ(times, 1) << i << " " << node.id.text();
      }
    }
    for (const DrawTile& d : cut.draws) EXPECT_FALSE(lost.contains(d.node));
  }
}

TEST_P(LodCutTest, SeveralTreesAreCutEachByItself) {
  codec::TreeLayout layout = bounds_.layout();
  layout.origin_m = {2990, 0};
  const cache::TileBounds east = bounds_.placed(layout);
  const std::array<const cache::TileBounds*, 2> both{&bounds_, &east};
  std::mt19937 random(9);
  for (int i = 0; i < 20; ++i) {
    const Camera c = camera(random);
    Camera moved = c;
    moved.eye.x -= 2990;
    moved.target.x -= 2990;
    const auto all = [](std::uint32_t, std::uint32_t) { return TileState::kResident; };
    const LodCut cut = lod_cut(both, c, {1}, all);
    for (std::uint32_t tree = 0; tree < 2; ++tree) {
      std::vector<std::uint32_t> nodes;
      for (const DrawTile& d : cut.draws) {
        if (d.tree == tree) nodes.push_back(d.node);
      }
      std::vector<std::uint32_t> alone;
      for (const DrawTile& d : lod_cut(bounds_, tree == 0 ? c : moved, {1}, kAll).draws) alone.push_back(d.node);
      EXPECT_EQ(nodes, alone) << i << " " << tree;
    }
  }
}

TEST_P(LodCutTest, LooksAwayAndDrawsNothing) {
  Camera away;
  away.eye = {1500, 500, 300};
  away.target = {1500, 5000, 300};
  const LodCut cut = lod_cut(bounds_, away, {1}, [](std::uint32_t) { return false; });
  EXPECT_TRUE(cut.draws.empty());
  EXPECT_TRUE(cut.requests.empty());
  EXPECT_TRUE(cut.complete);
}

}  // namespace
}  // namespace tintree::render
