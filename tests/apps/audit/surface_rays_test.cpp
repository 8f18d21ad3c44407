#include "apps/audit/surface_rays.h"

#include <cmath>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::audit {
namespace {

using test::HeightGrid;
using test::hills;

/// The least t at which the ray meets a triangle with these corners (column, row, height), by Moeller and Trumbore.
double meet(const GridRay& ray, const std::array<std::array<double, 3>, 3>& p) {
  const auto minus = [](const auto& a, const auto& b) { return std::array{a[0] - b[0], a[1] - b[1], a[2] - b[2]}; };
  const auto cross = [](const auto& a, const auto& b) {
    return std::array{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto dot = [](const auto& a, const auto& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const auto ab = minus(p[1], p[0]);
  const auto ac = minus(p[2], p[0]);
  const auto h = cross(ray.step, ac);
  const double det = dot(ab, h);
  const auto s = minus(ray.origin, p[0]);
  const double u = dot(s, h) / det;
  const auto q = cross(s, ab);
  const double v = dot(ray.step, q) / det;
  const double t = dot(ac, q) / det;
  return u >= -1e-12 && v >= -1e-12 && u + v <= 1 + 1e-12 && t > 0 ? t : SurfaceRays::kMiss;
}

double brute_force(const HeightGrid& grid, const GridRay& ray) {
  double nearest = SurfaceRays::kMiss;
  for (std::int64_t r = 0; r + 1 < grid.rows; ++r) {
    for (std::int64_t c = 0; c + 1 < grid.columns; ++c) {
      const auto corner = [&](std::int64_t i, std::int64_t j) {
        return std::array{static_cast<double>(i), static_cast<double>(j), grid.at(i, j)};
      };
      if (grid.has_lower(c, r))
        nearest = std::min(nearest, meet(ray, {corner(c, r), corner(c, r + 1), corner(c + 1, r + 1)}));
      if (grid.has_upper(c, r))
        nearest = std::min(nearest, meet(ray, {corner(c, r), corner(c + 1, r + 1), corner(c + 1, r)}));
    }
  }
  return nearest;
}

class SurfaceRaysTest : public testing::Test {
 protected:
  void make(int columns, int rows, const test::HeightFunction& height) {
    const std::string path = dir_.file("dem.tif");
    test::write_raster(path, {.columns = columns, .rows = rows, .type = test::SampleType::kFloat32}, height);
    auto source = cache::RasterSource::open(path);
    ASSERT_TRUE(source) << source.error().text();
    grid_ = test::read_grid(*source);
    auto rays = SurfaceRays::scan(std::make_shared<cache::RasterSource>(std::move(*source)), 1 << 20,
                                  [](std::int64_t) { return true; });
    ASSERT_TRUE(rays) << rays.error().text();
    rays_ = std::make_unique<SurfaceRays>(std::move(*rays));
  }

  test::TempDir dir_;
  HeightGrid grid_;
  std::unique_ptr<SurfaceRays> rays_;
};

TEST_F(SurfaceRaysTest, MeetTheFirstTriangleOfAll) {
  // Wider than a block, with holes, from above, from the side, from below and straight down.
  make(300, 70, [](int c, int r) { return (c / 7 + r / 5) % 11 == 0 ? test::kMissing : hills(c, r, 30); });
  std::mt19937 random(3);
  std::uniform_real_distribution<> dice(0, 1);
  int hits = 0;
  for (int i = 0; i < 400; ++i) {
    GridRay ray;
    ray.origin = {-50 + 400 * dice(random), -50 + 170 * dice(random), -60 + 160 * dice(random)};
    const std::array<double, 3> to{300 * dice(random), 70 * dice(random), -30 + 60 * dice(random)};
    for (std::size_t k = 0; k < 3; ++k) ray.step[k] = (to[k] - ray.origin[k]) / 100;
    if (i % 20 == 0) ray.step = {0, 0, -1};
    if (i % 20 == 1) ray.step = {1, 0, 0};
    const double expected = brute_force(grid_, ray);
    const auto found = rays_->cast(ray);
    ASSERT_TRUE(found);
    if (expected == SurfaceRays::kMiss) {
      EXPECT_EQ(*found, SurfaceRays::kMiss) << i;
    } else {
      EXPECT_NEAR(*found, expected, 1e-6 * (1 + expected)) << i;
      ++hits;
    }
  }
  EXPECT_GT(hits, 200);
}

TEST_F(SurfaceRaysTest, GiveTheHeightOfTheSurface) {
  make(270, 40, [](int c, int r) { return c == 100 ? test::kMissing : hills(c, r, 30); });
  std::mt19937 random(4);
  std::uniform_real_distribution<> dice(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const double c = 269 * dice(random);
    const double r = 39 * dice(random);
    const double expected = grid_.surface(c, r);
    const auto found = rays_->height(c, r);
    ASSERT_TRUE(found);
    if (std::isnan(expected)) {
      EXPECT_TRUE(std::isnan(*found));
    } else {
      EXPECT_NEAR(*found, expected, 1e-4);
    }
  }
  EXPECT_TRUE(std::isnan(rays_->height(-0.1, 3).value()));
  EXPECT_TRUE(std::isnan(rays_->height(3, 39.1).value()));
}

}  // namespace
}  // namespace tintree::audit
