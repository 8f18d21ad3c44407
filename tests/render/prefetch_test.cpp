#include "render/prefetch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <span>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "tests/render/analytic_tree.h"

namespace tintree::render {
namespace {

TEST(CameraTrail, GoesOnAsItWent) {
  CameraTrail trail;
  Camera c;
  for (int i = 0; i <= 20; ++i) {
    c.eye = {10.0 * i, -3.0 * i, 500};
    c.target = c.eye + glm::dvec3(0, 100, -20);
    trail.add(7 + 0.1 * i, c);
  }
  const Camera ahead = trail.ahead(2);
  EXPECT_NEAR(glm::distance(ahead.eye, c.eye + glm::dvec3(200, -60, 0)), 0, 1e-6);
  EXPECT_NEAR(glm::distance(ahead.target - ahead.eye, glm::dvec3(0, 100, -20)), 0, 1e-6);
}

TEST(CameraTrail, FollowsACurve) {
  const auto place = [](double seconds) {
    return glm::dvec3(1000 * std::cos(0.4 * seconds), 1000 * std::sin(0.4 * seconds), 300 + 20 * seconds);
  };
  CameraTrail trail;
  Camera c;
  for (int i = 0; i <= 120; ++i) {
    c.eye = place(i / 60.0);
    trail.add(i / 60.0, c);
  }
  const glm::dvec3 straight = c.eye + (place(2) - place(1.5)) / 0.5;
  EXPECT_LT(glm::distance(trail.ahead(1).eye, place(3)), 0.2 * glm::distance(straight, place(3)));
}

TEST(CameraTrail, ATremblingHandDoesNotThrowItFar) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> tremble(-1, 1);
  CameraTrail trail;
  Camera c;
  glm::dvec3 first(0);
  for (int i = 0; i <= 30; ++i) {
    c.eye = glm::dvec3(2 * i, 0, 100) + glm::dvec3(tremble(random), tremble(random), tremble(random));
    trail.add(i / 60.0, c);
    const double passed = i / 60.0;
    if (i == 0) {
      first = c.eye;
      continue;
    }
    EXPECT_LE(glm::distance(trail.ahead(1).eye, c.eye), 2 * glm::distance(c.eye, first) / passed + 1e-9);
  }
}

TEST(CameraTrail, OnePlaceOrAJumpOfTheClockGivesNoVelocity) {
  CameraTrail trail;
  Camera c;
  c.eye = {1, 2, 3};
  trail.add(0, c);
  EXPECT_EQ(trail.ahead(5).eye, c.eye);
  c.eye = {1000, 2, 3};
  for (const double seconds : {100.0, 100.0, 3.0}) {  // A pause, no time at all, and back.
    trail.add(seconds, c);
    EXPECT_EQ(trail.ahead(5).eye, c.eye) << seconds;
  }
}

/// Whether a node is there, or all that lies below it.
bool covers(const cache::TileBounds& bounds, std::uint32_t n, const IsResident& is_here) {
  if (is_here(n)) return true;
  const cache::TileNode& at = bounds.nodes()[n];
  for (int i = 0; i < std::popcount(at.child_mask); ++i) {
    if (!covers(bounds, at.first_child + static_cast<std::uint32_t>(i), is_here)) return false;
  }
  return at.child_mask != 0;
}

class PrefetchTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    test::AnalyticTree tree;
    tree.columns = tree.rows = 513;
    tree.tile_cells = 16;
    bounds_ = tree.bounds();
  }

  static Camera camera(double azimuth) {
    Camera c;
    c.eye = {1500, -1400, 260};
    c.target = c.eye + glm::dvec3(std::sin(azimuth), std::cos(azimuth), -0.4);
    return c;
  }

  static std::vector<cache::TileRef> ahead(const Camera& c, const std::set<std::uint32_t>& here, std::size_t most) {
    const std::array<const cache::TileBounds*, 1> trees{&bounds_};
    const auto states = [&](std::uint32_t, std::uint32_t n) {
      return here.contains(n) ? TileState::kResident : TileState::kMissing;
    };
    return prefetch(
        trees, c, {8}, states, [](const cache::TileRef&) { return TextureState::kNone; }, most);
  }

  static std::uint32_t node(const cache::TileRef& t) { return static_cast<std::uint32_t>(bounds_.find(t.id)); }

  inline static cache::TileBounds bounds_;
};

// Once all of it is there, the eye may turn as it likes: whatever it wants is there, or something finer.
TEST_F(PrefetchTest, HasWhatTheEyeWantsInEveryDirection) {
  std::set<std::uint32_t> here;
  for (const cache::TileRef& t : ahead(camera(0), here, 100000)) here.insert(node(t));
  EXPECT_GT(here.size(), 30U);
  EXPECT_LT(here.size(), bounds_.nodes().size() / 2);
  for (int turn = 0; turn < 16; ++turn) {
    const LodCut cut =
        lod_cut(bounds_, camera(turn * std::numbers::pi / 8), {8}, [&](std::uint32_t n) { return here.contains(n); });
    EXPECT_FALSE(cut.draws.empty());
    for (const cache::TileRef& missing : cut.requests) {
      // Seen at a slant the vertical counts for less: a coarser tile than prefetched may do.
      const auto is_here = [&](std::uint32_t n) { return here.contains(n); };
      EXPECT_TRUE(covers(bounds_, node(missing), is_here)) << missing.id.text();
    }
  }
}

TEST_F(PrefetchTest, NamesWhatIsMissingAndMostNeededFirst) {
  const auto all = ahead(camera(1), {}, 100000);
  const auto some = ahead(camera(1), {}, 10);
  ASSERT_EQ(some.size(), 10U);
  EXPECT_TRUE(std::ranges::equal(some, std::span(all).first(10)));
  const std::set<std::uint32_t> here{node(all[0]), node(all[3])};
  const auto rest = ahead(camera(1), here, 100000);
  EXPECT_EQ(rest.size(), all.size() - 2);
  for (const cache::TileRef& t : rest) EXPECT_FALSE(here.contains(node(t)));
  const auto distance = [](const cache::TileRef& t) {
    const cache::Box b = bounds_.box(bounds_.nodes()[node(t)]);
    return glm::distance(glm::dvec2((b.min[0] + b.max[0]) / 2, (b.min[1] + b.max[1]) / 2), glm::dvec2(1500, -1400));
  };
  EXPECT_LT(distance(all.front()), distance(all.back()));
}

/// Textures, and finer ones in leaves but for some squares.
class PrefetchTexturesTest : public testing::TestWithParam<int> {
 protected:
  PrefetchTexturesTest() {
    tree_.columns = tree_.rows = 257;
    tree_.tile_cells = 16;
    tree_.levels_per_doubling = GetParam();
    tree_.texture_depth = 3;
    tree_.height_m = [](double, double) { return 0; };  // Texels alone ask for tiles.
    bounds_ = tree_.bounds();
    bounds_.set_textures(16, tree_.texture_depth);
  }

  static Camera camera(double azimuth) {
    Camera c;
    c.width_px = c.height_px = 64;
    c.eye = {700, -1200, 60};
    c.target = c.eye + glm::dvec3(std::sin(azimuth), std::cos(azimuth), -0.3);
    return c;
  }

  /// Every third square of the coarsest has none, and so has nothing in it any.
  bool has(const codec::TileId& id) const {
    const codec::TreeLayout squares = tree_.squares();
    const codec::TreeLayout& layout = bounds_.layout();
    codec::TileId first = id;
    while (squares.halvings(first.level) > layout.halvings(layout.leaf_level) + 1) first = squares.parent(first);
    return (first.x + first.y) % 3 != 0;
  }
  bool is_part(const codec::TileId& id) const { return id.level > bounds_.layout().leaf_level; }
  TextureState known(const cache::TileRef& t, const std::set<std::uint64_t>& here) const {
    if (!here.contains(t.id.key())) return TextureState::kMissing;
    return has(t.id) ? TextureState::kResident : TextureState::kNone;
  }

  test::AnalyticTree tree_;
  cache::TileBounds bounds_;
};

// Once it names no more, whatever lies on the ground in any direction is as fine as a view wants it.
TEST_P(PrefetchTexturesTest, HaveWhatTheEyeWantsInEveryDirection) {
  const std::array<const cache::TileBounds*, 1> trees{&bounds_};
  std::set<std::uint64_t> here;
  const TileStates tile = [&](std::uint32_t, std::uint32_t n) {
    return here.contains(bounds_.nodes()[n].id.key()) ? TileState::kResident : TileState::kMissing;
  };
  const TextureStates texture = [&](const cache::TileRef& t) { return known(t, here); };
  std::size_t parts = 0;
  while (true) {
    const auto named = prefetch(trees, camera(0), {}, tile, texture, 100000);
    if (named.empty()) break;
    for (const cache::TileRef& t : named) {
      ASSERT_TRUE(here.insert(t.id.key()).second) << t.id.text() << " is there";
      if (!is_part(t.id)) continue;
      ++parts;
      // What is round it has one, or it would not have been read.
      EXPECT_TRUE(has(t.id) ||
                  tree_.squares().halvings(t.id.level) == bounds_.layout().halvings(bounds_.layout().leaf_level) + 1);
    }
  }
  EXPECT_GT(parts, 100U);
  std::size_t most = 0;
  for (std::int64_t side = 2; side <= 8; side *= 2) most += static_cast<std::size_t>(16 * 16 * side * side);
  EXPECT_LT(parts, most / 4) << "not all of the tree";
  int seen = 0;
  for (int turn = 0; turn < 16; ++turn) {
    const Camera c = camera(turn * std::numbers::pi / 8);
    LodCut cut = lod_cut(bounds_, c, {}, [](std::uint32_t) { return true; });
    for (const DrawTile& d : cut.draws) {
      const auto is_here = [&](std::uint32_t n) { return here.contains(bounds_.nodes()[n].id.key()); };
      EXPECT_TRUE(covers(bounds_, d.node, is_here)) << bounds_.nodes()[d.node].id.text();
    }
    add_texture_parts(cut, trees, c, texture);
    EXPECT_TRUE(cut.requests.empty()) << cut.requests.front().id.text();
    seen += static_cast<int>(cut.parts.size());
  }
  EXPECT_GT(seen, 100);
}

TEST_P(PrefetchTexturesTest, CoarserOnesComeFirst) {
  const std::array<const cache::TileBounds*, 1> trees{&bounds_};
  const auto tiles = [](std::uint32_t, std::uint32_t) { return TileState::kResident; };
  const auto none = [](const cache::TileRef&) { return TextureState::kMissing; };
  const auto all = prefetch(trees, camera(0), {}, tiles, none, 100000);
  ASSERT_GT(all.size(), 20U);
  const int first = bounds_.layout().coarsest_level(bounds_.layout().halvings(bounds_.layout().leaf_level) + 1);
  for (const cache::TileRef& t : all) EXPECT_EQ(t.id.level, first);
  const auto some = prefetch(trees, camera(0), {}, tiles, none, 8);
  EXPECT_TRUE(std::ranges::equal(some, std::span(all).first(8)));
  // What is damaged will not come, but what lies on it may.
  const auto damaged = [&](const cache::TileRef& t) {
    return t.id.level == first ? TextureState::kLost : TextureState::kMissing;
  };
  const auto finer = prefetch(trees, camera(0), {}, tiles, damaged, 100000);
  ASSERT_GT(finer.size(), 20U);
  for (const cache::TileRef& t : finer) EXPECT_GT(t.id.level, first);
}

INSTANTIATE_TEST_SUITE_P(LevelsPerDoubling, PrefetchTexturesTest, testing::Values(1, 2));

}  // namespace
}  // namespace tintree::render
