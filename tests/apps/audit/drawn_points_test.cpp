#include "apps/audit/drawn_points.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/support/regular_tree.h"
#include "tests/support/temp_dir.h"

namespace tintree::audit {
namespace {

using test::TestTree;

constexpr double kMiss = SurfaceRays::kMiss;
/// A vertex in the middle of the view, on the finest level.
constexpr codec::TileId kMiddle{2, 1, 1};

/// The leaves of a tree, whose meshes have every sample, from a place above them; 10 m are a pixel there.
class DrawnPointsTest : public testing::Test {
 protected:
  DrawnPointsTest() {
    test::write_raster(dem_, {.columns = 65, .rows = 50, .dx = 10, .dy = 10},
                       [](int c, int r) { return test::hills(c, r, 40); });
    tree_ = test::make_regular_tree(dem_, {.tile_cells = 16});
    camera_.eye = {320, -900, 500};
    camera_.target = {320, -245, 40};
    camera_.width_px = 96;
    camera_.height_px = 72;
    frame_.emplace(tree_.manifest.layout, camera_, 1.0);
    auto source = cache::RasterSource::open(dem_);
    if (!source) throw std::runtime_error(source.error().text());
    auto rays = SurfaceRays::scan(std::make_shared<cache::RasterSource>(std::move(*source)), 1 << 20,
                                  [](std::int64_t) { return true; });
    if (!rays) throw std::runtime_error(rays.error().text());
    rays_.emplace(std::move(*rays));
    for (std::size_t i = 0; i < frame_->pixels(); ++i) {
      surface_m_.push_back(rays_->cast(frame_->grid_ray(frame_->ray(i))).value());
    }
  }

  Expected<DrawnMeshRays> meshes() {
    test::write_tree(path_, tree_);
    const auto store = cache::TileStore::open(path_);
    if (!store) return tl::unexpected(store.error());
    render::LodCut cut;
    const auto nodes = store->bounds().nodes();
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i].id.level == tree_.manifest.layout.leaf_level) cut.draws.push_back({.node = i});
    }
    return DrawnMeshRays::read(*store, cut, camera_.eye);
  }

  DrawnPoints compare(const std::vector<double>& drawn_m) {
    const auto points = compare_drawn_points({*frame_, *rays_, surface_m_}, drawn_m, [this] { return meshes(); });
    if (!points) throw std::runtime_error(points.error().text());
    return *points;
  }

  /// Raises a vertex by six pixels and returns the pixel that shows it best.
  std::size_t raise_vertex() {
    codec::TileMesh mesh = tree_.mesh(kMiddle);
    codec::GridVertex* vertex = nullptr;
    for (codec::GridVertex& v : mesh.vertices) {
      if (v.x == 8 && v.y == 8) vertex = &v;
    }
    vertex->z += static_cast<std::int32_t>(60 / tree_.manifest.layout.z_step_m.back());
    tree_.set_mesh(kMiddle, mesh);
    const DrawnMeshRays wrong = meshes().value();
    std::size_t best = 0;
    double most_m = 0;
    for (std::size_t i = 0; i < frame_->pixels(); ++i) {
      if (surface_m_[i] == kMiss || surface_m_[i] - wrong.cast(frame_->ray(i)) <= most_m) continue;
      best = i;
      most_m = surface_m_[i] - wrong.cast(frame_->ray(i));
    }
    EXPECT_GT(most_m, 20);
    return best;
  }

  test::TempDir dir_;
  std::string dem_ = dir_.file("dem.tif");
  std::string path_ = dir_.file("tree.tintree");
  TestTree tree_;
  render::Camera camera_;
  std::optional<ViewFrame> frame_;
  std::optional<SurfaceRays> rays_;
  std::vector<double> surface_m_;
  std::size_t middle_ = 36 * 96 + 48;  ///< A pixel that shows terrain.
};

TEST_F(DrawnPointsTest, RaysMeetTheMeshesWhereTheyMeetTheSurface) {
  const DrawnMeshRays exact = meshes().value();
  int hits = 0;
  for (std::size_t i = 0; i < frame_->pixels(); ++i) {
    if (surface_m_[i] == kMiss) continue;
    EXPECT_NEAR(exact.cast(frame_->ray(i)), surface_m_[i], 0.1) << i;
    ++hits;
  }
  EXPECT_GT(hits, 2000);
  EXPECT_EQ(exact.cast({0, 0, 1}), kMiss);
}

TEST_F(DrawnPointsTest, DistancesAreThoseToTheNearestOfManyPoints) {
  const DrawnMeshRays exact = meshes().value();
  constexpr double kApart = 0.05;   // cells between the points looked at
  constexpr double kBetween_m = 1;  // from a point of the ground to the next of them, as steep as it is
  std::mt19937 random(3);
  std::uniform_real_distribution<> dice(0, 1);
  for (int k = 0; k < 20; ++k) {
    const double column = 5 + 55 * dice(random);
    const double row = 5 + 40 * dice(random);
    const glm::dvec3 p(10 * column, -10 * row, rays_->height(column, row).value() + 40 * (dice(random) - 0.5));
    double nearest_m = kMiss;
    for (double r = row - 2; r <= row + 2; r += kApart) {
      for (double c = column - 2; c <= column + 2; c += kApart) {
        nearest_m = std::min(nearest_m, glm::distance(p, {10 * c, -10 * r, rays_->height(c, r).value()}));
      }
    }
    const double found_m = exact.distance_m(p);
    EXPECT_LE(found_m, nearest_m + 0.01);
    EXPECT_GE(found_m + kBetween_m, nearest_m);
  }
}

TEST_F(DrawnPointsTest, TellADriversPixelFromTheMesh) {
  ASSERT_NE(surface_m_[middle_], kMiss);
  for (const double factor : {0.9, 1.1}) {
    std::vector<double> drawn_m = surface_m_;
    drawn_m[middle_] *= factor;
    const DrawnPoints points = compare(drawn_m);
    EXPECT_EQ(points.amiss_px, 1U);
    EXPECT_LE(points.max_px, 0.01);
    const auto unknown = compare_drawn_points({*frame_, *rays_, surface_m_}, drawn_m, nullptr);
    ASSERT_TRUE(unknown);
    EXPECT_EQ(unknown->amiss_px, 0U);
    EXPECT_GT(unknown->max_px, 2);
  }
  EXPECT_EQ(compare(surface_m_).amiss_px, 0U);
}

TEST_F(DrawnPointsTest, FindAVertexThatIsReallyOff) {
  const std::size_t pixel = raise_vertex();
  // Only one pixel shows it, with the depth that the mesh has.
  std::vector<double> drawn_m = surface_m_;
  drawn_m[pixel] = static_cast<float>(meshes().value().cast(frame_->ray(pixel)));
  const DrawnPoints points = compare(drawn_m);
  EXPECT_EQ(points.amiss_px, 0U);
  EXPECT_GT(points.max_px, 2);
}

TEST_F(DrawnPointsTest, FindAWrongMeshBehindAFalseDepth) {
  const std::size_t pixel = raise_vertex();
  std::vector<double> drawn_m = surface_m_;
  drawn_m[pixel] *= 0.7;
  const DrawnPoints points = compare(drawn_m);
  EXPECT_EQ(points.amiss_px, 1U);
  EXPECT_GT(points.max_px, 2);
}

TEST_F(DrawnPointsTest, ExcuseNoMoreThanSinglePixels) {
  std::vector<double> drawn_m = surface_m_;
  drawn_m[middle_] *= 0.9;
  drawn_m[middle_ + 30] *= 0.9;
  const DrawnPoints points = compare(drawn_m);
  EXPECT_EQ(points.amiss_px, 0U);
  EXPECT_GT(points.max_px, 2);
}

}  // namespace
}  // namespace tintree::audit
