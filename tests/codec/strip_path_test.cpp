#include "codec/strip_path.h"

#include <bit>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tintree::codec {
namespace {

/// The productions of the paper's appendix, A_L as "AL".
const std::map<std::string, std::vector<std::string>> kProductions{{"AL", {"CL", "BL"}}, {"AR", {"CR", "BR"}},
                                                                   {"BL", {"CR", "AL"}}, {"BR", {"CL", "AR"}},
                                                                   {"CL", {"AL", "BR"}}, {"CR", {"AR", "BL"}}};

/// Its Table 1; "" is the path's end.
const std::map<std::string, std::set<std::string>> kFollow{{"AL", {"AL", "BR", "CL", ""}}, {"AR", {"AR", "BL", "CR"}},
                                                           {"BL", {"AL", "BR", "CL", ""}}, {"BR", {"AR", "BL", "CR"}},
                                                           {"CL", {"AR", "BL", "CR"}},     {"CR", {"AL", "BR", "CL"}}};

TEST(StripPath, HasTheFollowSetsOfThePaper) {
  // Expansion of the start word by random productions, until nothing new has turned up for long.
  std::mt19937 random(1);
  std::map<std::string, std::set<std::string>> follow;
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<std::string> word(4, "AL");
    for (int step = 0; step < 60; ++step) {
      const std::size_t at = random() % word.size();
      const std::vector<std::string> by = kProductions.at(word[at]);
      word[at] = by[0];
      word.insert(word.begin() + static_cast<std::ptrdiff_t>(at) + 1, by[1]);
      for (std::size_t i = 0; i < word.size(); ++i) follow[word[i]].insert(i + 1 < word.size() ? word[i + 1] : "");
    }
  }
  EXPECT_EQ(follow, kFollow);
}

TEST(StripPath, InfersTheWindingThatFollowSetsAllow) {
  for (const auto& [before, after] : kFollow) {
    for (const std::string& next : after) {
      if (next.empty()) continue;
      const auto type = [](char c) { return static_cast<StripType>(c - 'A'); };
      StripWinding winding = StripWinding::before(type(before[0]), before[1] == 'L');
      EXPECT_EQ(winding.next(type(before[0])), before[1] == 'L');
      EXPECT_EQ(winding.next(type(next[0])), next[1] == 'L') << before << ' ' << next;
    }
  }
}

/// A random restricted quadtree over a square, split by the hierarchy's own rule.
std::set<std::pair<std::int64_t, std::int64_t>> random_splits(std::mt19937& random, std::int64_t span, int wishes) {
  std::set<std::pair<std::int64_t, std::int64_t>> splits{{span / 2, span / 2}};
  for (const std::int64_t y : {std::int64_t{0}, span}) {
    for (const std::int64_t x : {std::int64_t{0}, span}) splits.insert({x, y});
  }
  const auto force = [&](const auto& self, const SplitPoint& p) -> void {
    if (p.x < 0 || p.y < 0 || p.x > span || p.y > span || !splits.insert({p.x, p.y}).second) return;
    for (const SplitPoint& parent : split_parents(p)) self(self, parent);
  };
  for (int k = 0; k < wishes; ++k) {
    const auto n = static_cast<unsigned>(span + 1);
    force(force, {static_cast<std::int64_t>(random() % n), static_cast<std::int64_t>(random() % n)});
  }
  return splits;
}

TEST(StripPath, VisitsEveryTriangleAcrossItsSides) {
  std::mt19937 random(2);
  for (const int wishes : {0, 1, 3, 10, 40, 2000}) {
    const std::int64_t span = 64;
    const auto splits = random_splits(random, span, wishes);
    std::vector<StripStep> steps;
    walk_strip(
        span,
        [&](const SplitPoint& p) {
          return splits.contains({p.x, p.y});
        },
        [&](const StripStep& s) { steps.push_back(s); });
    StripWinding winding;
    const SplitPoint &v1 = steps[0].v1, &v2 = steps[0].v2;
    EXPECT_TRUE(steps[0].left);
    StripEdge edge{1, std::countr_zero(static_cast<std::uint64_t>(v2.x - v1.x))};
    std::int64_t area = 0;
    std::set<std::pair<std::int64_t, std::int64_t>> seen{{v1.x, v1.y}, {v2.x, v2.y}};
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const StripStep& s = steps[i];
      const std::int64_t doubled = (s.v3.x - s.v1.x) * (s.v2.y - s.v1.y) - (s.v2.x - s.v1.x) * (s.v3.y - s.v1.y);
      EXPECT_GT(doubled, 0);
      area += doubled;
      EXPECT_EQ(winding.next(s.type), s.left);
      // What the decoder computes from the entering edge.
      const auto vector = [](const StripEdge& e) {
        const auto d = static_cast<std::size_t>(e.direction);
        return SplitPoint{kStripX[d] * (std::int64_t{1} << e.size), kStripY[d] * (std::int64_t{1} << e.size)};
      };
      EXPECT_EQ(vector(edge), (SplitPoint{s.v2.x - s.v1.x, s.v2.y - s.v1.y}));
      edge = edge.next(s.type, s.left);
      const SplitPoint out = vector(edge);
      EXPECT_EQ(s.v3,
                s.left ? (SplitPoint{s.v1.x + out.x, s.v1.y + out.y}) : (SplitPoint{s.v2.x - out.x, s.v2.y - out.y}));
      // Never on the border: 9 bits are enough for a 513-sample tile (section 4.2).
      EXPECT_TRUE(s.v1.x > 0 && s.v1.y > 0 && s.v1.x < span && s.v1.y < span);
      seen.insert({s.v3.x, s.v3.y});
      if (i + 1 == steps.size()) break;
      EXPECT_EQ(steps[i + 1].v1, s.left ? s.v1 : s.v3);
      EXPECT_EQ(steps[i + 1].v2, s.left ? s.v3 : s.v2);
    }
    EXPECT_EQ(area, 2 * span * span);
    EXPECT_EQ(seen, splits);
  }
}

}  // namespace
}  // namespace tintree::codec
