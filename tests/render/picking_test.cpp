#include "render/picking.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "tests/render/analytic_tree.h"

namespace tintree::render {
namespace {

using Tiles = std::map<std::int64_t, std::shared_ptr<const cache::DrawableTile>>;

class Picking : public testing::TestWithParam<double> {
 protected:
  void SetUp() override {
    tree_.axes = {{std::cos(GetParam()), std::sin(GetParam())}, {std::sin(GetParam()), -std::cos(GetParam())}};
    bounds_ = tree_.bounds();
    for (const codec::TileId& id : tree_.tiles()) {
      tiles_[id.key()] =
          std::make_shared<cache::DrawableTile>(cache::make_drawable(tree_.layout(), id, tree_.mesh(id)));
    }
  }

  Trees trees() const { return {&bounds_at_, 1}; }

  FindTile find() const {
    return [this](const cache::TileRef& tile) {
      const auto found = tiles_.find(tile.id.key());
      return found == tiles_.end() ? nullptr : found->second;
    };
  }

  /// The smallest t at which the ray crosses a triangle of a mesh, by planes and areas in the world frame.
  double crossing(const codec::TileId& id, const Ray& ray) const {
    const codec::TileMesh mesh = tree_.mesh(id);
    const codec::GridFrame frame(tree_.layout(), id, mesh);
    double first = std::numeric_limits<double>::infinity();
    for (const codec::Triangle& t : mesh.triangles) {
      glm::dvec3 p[3];
      for (std::size_t i = 0; i < 3; ++i) {
        const auto w = frame.world(mesh.vertices[t[i]]);
        p[i] = {w[0], w[1], w[2]};
      }
      const glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
      const double along = glm::dot(n, ray.direction);
      if (along == 0) continue;
      const double at = glm::dot(n, p[0] - ray.origin) / along;
      const glm::dvec3 x = ray.origin + at * ray.direction;
      double areas = 0;
      for (std::size_t i = 0; i < 3; ++i) areas += glm::length(glm::cross(p[i] - x, p[(i + 1) % 3] - x));
      if (at >= 0 && areas <= glm::length(n) * (1 + 1e-9)) first = std::min(first, at);
    }
    return first;
  }

  double crossing_of_level(int level, const Ray& ray) const {
    double first = std::numeric_limits<double>::infinity();
    for (const codec::TileId& id : tree_.tiles())
      if (id.level == level) first = std::min(first, crossing(id, ray));
    return first;
  }

  /// Rays from above and beside the terrain to places on and beside it.
  std::vector<Ray> rays(int count) const {
    std::mt19937 random(7);
    const auto in = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
    std::vector<Ray> out;
    for (int i = 0; i < count; ++i) {
      const auto from = tree_.layout().world(in(-60, 190), in(-60, 190));
      const auto to = tree_.layout().world(in(-20, 150), in(-20, 150));
      const glm::dvec3 origin(from[0], from[1], in(-300, 900));
      const glm::dvec3 target(to[0], to[1], in(-80, 80));
      out.push_back({origin, (target - origin) * in(0.1, 3)});
    }
    return out;
  }

  test::AnalyticTree tree_;
  cache::TileBounds bounds_;
  const cache::TileBounds* bounds_at_ = &bounds_;
  Tiles tiles_;
};

TEST_P(Picking, FindsWhatBruteForceFindsOnTheLeaves) {
  int hits = 0;
  for (const Ray& ray : rays(150)) {
    const double expected = crossing_of_level(tree_.layout().leaf_level, ray);
    const auto found = pick(trees(), find(), ray);
    ASSERT_EQ(found.has_value(), std::isfinite(expected));
    if (!found) continue;
    ++hits;
    EXPECT_NEAR(found->t, expected, 1e-7 * std::max(1.0, expected));
    EXPECT_NEAR(glm::distance(found->at, ray.origin + expected * ray.direction), 0, 1e-3);
    EXPECT_EQ(bounds_.nodes()[found->node].id.level, tree_.layout().leaf_level);
  }
  EXPECT_GT(hits, 50);
  EXPECT_LT(hits, 150);
}

TEST_P(Picking, TakesCoarserTilesWhereFinerOnesAreMissing) {
  for (auto it = tiles_.begin(); it != tiles_.end();)
    it = codec::TileId::from_key(it->first).level > 0 ? tiles_.erase(it) : std::next(it);
  for (const Ray& ray : rays(60)) {
    const double expected = crossing_of_level(0, ray);
    const auto found = pick(trees(), find(), ray);
    ASSERT_EQ(found.has_value(), std::isfinite(expected));
    EXPECT_TRUE(!found || std::abs(found->t - expected) < 1e-7 * std::max(1.0, expected));
  }
  tiles_.clear();
  EXPECT_FALSE(pick(trees(), find(), rays(1)[0]));
}

TEST_P(Picking, GroundAtASampleHasItsHeight) {
  for (const std::int64_t column : {0, 1, 31, 32, 77, 128}) {
    for (const std::int64_t row : {0, 32, 50, 128}) {
      const auto [x, y] = tree_.layout().world(static_cast<double>(column), static_cast<double>(row));
      const auto ground = ground_at(trees(), find(), x, y);
      if (GetParam() != 0 && (column % 128 == 0 || row % 128 == 0)) continue;  // Rounding may take it over the edge.
      ASSERT_TRUE(ground) << column << ' ' << row;
      EXPECT_NEAR(ground->at.z, static_cast<double>(tree_.steps(column, row)) * 0.0625, 1e-6);
    }
  }
  const auto [x, y] = tree_.layout().world(-1, 5);
  EXPECT_FALSE(ground_at(trees(), find(), x, y));
}

INSTANTIATE_TEST_SUITE_P(NorthUpAndTurned, Picking, testing::Values(0.0, 0.6));

}  // namespace
}  // namespace tintree::render
