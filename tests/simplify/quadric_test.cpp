#include "simplify/quadric.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tintree::simplify {
namespace {

struct WeightedPlane {
  double a, b, c, weight;
};

/// A few planes and their quadric.
class QuadricTest : public testing::Test {
 protected:
  void draw(int count) {
    std::uniform_real_distribution<double> slope(-2, 2);
    std::uniform_real_distribution<double> height(-50, 50);
    std::uniform_real_distribution<double> weight(0.1, 3);
    planes_.clear();
    quadric_ = {};
    for (int i = 0; i < count; ++i) {
      planes_.push_back({slope(random_), slope(random_), height(random_), weight(random_)});
      const WeightedPlane& p = planes_.back();
      quadric_ += Quadric::of_plane(p.a, p.b, p.c, p.weight);
    }
  }

  double cost(double x, double y, double z) const {
    double sum = 0;
    for (const WeightedPlane& p : planes_) sum += p.weight * std::pow(z - (p.a * x + p.b * y + p.c), 2);
    return sum;
  }

  /// The weighted mean of the planes' heights.
  double mean_height(double x, double y) const {
    double sum = 0;
    double weights = 0;
    for (const WeightedPlane& p : planes_) {
      sum += p.weight * (p.a * x + p.b * y + p.c);
      weights += p.weight;
    }
    return sum / weights;
  }

  std::mt19937 random_{11};
  std::uniform_real_distribution<double> place_{-30, 30};
  std::vector<WeightedPlane> planes_;
  Quadric quadric_;
};

TEST_F(QuadricTest, BestHeightIsTheMean) {
  for (int round = 0; round < 50; ++round) {
    draw(1 + round % 7);
    const double x = place_(random_);
    const double y = place_(random_);
    EXPECT_NEAR(quadric_.best_height(x, y), mean_height(x, y), 1e-9);
  }
}

TEST_F(QuadricTest, PlanIsTheCostAtTheBestHeight) {
  for (int round = 0; round < 50; ++round) {
    draw(1 + round % 7);
    const double x = place_(random_);
    const double y = place_(random_);
    const double expected = cost(x, y, mean_height(x, y));
    EXPECT_NEAR(quadric_.plan().at(x, y), expected, 1e-8 * (1 + expected));
    for (const double dz : {-0.5, 0.5}) EXPECT_GT(cost(x, y, mean_height(x, y) + dz), expected);
  }
}

TEST_F(QuadricTest, MinimiseFindsTheDenseMinimum) {
  for (int round = 0; round < 40; ++round) {
    draw(3 + round % 5);
    const double mx = place_(random_);
    const double my = place_(random_);
    const double ridge = 0.05 + 0.1 * (round % 10);
    double px = 0;
    double py = 0;
    quadric_.plan().minimise(mx, my, ridge, px, py);
    const auto value = [&](double x, double y) {
      return cost(x, y, mean_height(x, y)) + ridge * (std::pow(x - mx, 2) + std::pow(y - my, 2));
    };
    const double least = value(px, py);
    for (int j = -20; j <= 20; ++j) {
      for (int i = -20; i <= 20; ++i) EXPECT_GE(value(px + 0.25 * i, py + 0.25 * j), least * (1 - 1e-9) - 1e-9);
    }
  }
}

TEST_F(QuadricTest, MinimiseStaysPutOnOnePlane) {
  draw(1);
  double px = 0;
  double py = 0;
  quadric_.plan().minimise(3, 4, 0.1, px, py);
  EXPECT_NEAR(px, 3, 1e-6);
  EXPECT_NEAR(py, 4, 1e-6);
  EXPECT_NEAR(quadric_.plan().at(3, 4), 0, 1e-9);
}

}  // namespace
}  // namespace tintree::simplify
