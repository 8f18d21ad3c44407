#include "apps/audit/image_audit.h"

#include <algorithm>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/support/naive_measure.h"
#include "tests/support/regular_tree.h"
#include "tests/support/temp_dir.h"

namespace tintree::audit {
namespace {

using test::TestTree;

/// A tree of 15 tiles on three levels, small pictures, four views.
class ImageAuditTest : public testing::Test {
 protected:
  ImageAuditTest() {
    make([](int c, int r) { return test::hills(c, r, 40); });
  }

  void make(const test::HeightFunction& height, double turn_rad = 0) {
    test::write_raster(dem_, {.columns = 65, .rows = 50, .dx = 10, .dy = 10, .turn_rad = turn_rad}, height);
    tree_ = test::make_regular_tree(dem_, {.tile_cells = 16});
  }

  ImageReport audit() {
    test::write_tree(path_, tree_);
    const auto store = cache::TileStore::open(path_);
    const auto source = cache::RasterSource::open(dem_);
    if (!store || !source) throw std::runtime_error("cannot open");
    const AuditContext context{*store, *source, [](std::int64_t) { return true; }};
    ImageOptions options;
    options.flight_views = 3;
    options.random_views = 3;
    options.width_px = 160;
    options.height_px = 120;
    violations_.clear();
    auto report = audit_images(context, options, violations_);
    if (!report) throw std::runtime_error(report.error().text());
    return std::move(*report);
  }

  /// Some tile of every view must show what is done to all tiles.
  template <typename Change>
  void change_all(const Change& change) {
    for (cache::StoredTile& tile : tree_.tiles) {
      codec::TileMesh mesh = tree_.mesh(tile.info.id);
      change(mesh);
      tree_.set_mesh(tile.info.id, mesh);
    }
  }

  bool is_found(const std::string& what) const {
    return std::ranges::any_of(violations_, [&](const Violation& v) {
      return v.kind == ViolationKind::kImage && v.message.find(what) != std::string::npos;
    });
  }

  test::TempDir dir_;
  std::string dem_ = dir_.file("dem.tif");
  std::string path_ = dir_.file("tree.tintree");
  TestTree tree_;
  std::vector<Violation> violations_;
};

TEST_F(ImageAuditTest, PassesATreeOverATurnedGrid) {
  make([](int c, int r) { return test::hills(c, r, 40); }, 2.2);
  const ImageReport report = audit();
  for (const Violation& v : violations_) ADD_FAILURE() << v.message;
  for (const ViewReport& v : report.views) {
    EXPECT_GT(v.terrain_px, 0U) << v.name;
    EXPECT_LE(v.shift_max_px, 1) << v.name;
  }
}

TEST_F(ImageAuditTest, PassesAGoodTree) {
  const ImageReport report = audit();
  for (const Violation& v : violations_) ADD_FAILURE() << v.message;
  ASSERT_EQ(report.views.size(), 6U);
  std::uint64_t terrain = 0;
  double shift = 0;
  for (const ViewReport& v : report.views) {
    EXPECT_EQ(v.crack_px, 0U) << v.name;
    EXPECT_EQ(v.amiss_px, 0U) << v.name;
    EXPECT_GT(v.terrain_px, 0U) << v.name;
    EXPECT_LE(v.shift_max_px, 1) << v.name;
    terrain += v.terrain_px;
    shift = std::max(shift, v.shift_max_px);
  }
  EXPECT_GT(terrain, 6U * 160 * 120 / 10);
  EXPECT_GT(shift, 0.05) << "the views are so far away that they show nothing";
}

TEST_F(ImageAuditTest, TakesNoHoleForACrack) {
  make([](int c, int r) { return c > 30 && c < 34 && r > 20 && r < 26 ? test::kMissing : test::hills(c, r, 40); });
  tree_.manifest.layout.leaf_error_m = 0.5;  // far above what the meshes have: views from afar
  audit();
  for (const Violation& v : violations_) ADD_FAILURE() << v.message;
}

TEST_F(ImageAuditTest, FindsAMeshThatLiesTooHigh) {
  // Twenty leaf bounds up; the stored errors, by which a viewer goes, stay as they were.
  const double up_m = 20 * tree_.manifest.layout.leaf_error_m;
  change_all([&](codec::TileMesh& mesh) {
    mesh.z_offset += static_cast<std::int64_t>(up_m / tree_.manifest.layout.z_step_m[0]);
  });
  audit();
  EXPECT_TRUE(is_found("off by"));
}

/// What a driver draws of a wrong mesh must not pass for a pixel drawn amiss.
TEST_F(ImageAuditTest, FindsOneVertexOfATileThatLiesTooHigh) {
  const double up_m = 30 * tree_.manifest.layout.leaf_error_m;
  change_all([&](codec::TileMesh& mesh) {
    const auto [low, high] = std::ranges::minmax(mesh.vertices, {}, &codec::GridVertex::x);
    const auto inner = std::ranges::find_if(
        mesh.vertices, [half = high.x / 2](const codec::GridVertex& v) { return v.x == half && v.y == half; });
    if (inner != mesh.vertices.end()) inner->z += static_cast<int>(up_m / tree_.manifest.layout.z_step_m[0]);
  });
  const ImageReport report = audit();
  EXPECT_TRUE(is_found("off by"));
  EXPECT_TRUE(std::ranges::any_of(report.views, [](const ViewReport& v) { return v.drawn_max_px > v.limit_px + 1; }));
  EXPECT_TRUE(std::ranges::all_of(report.views, [](const ViewReport& v) { return v.amiss_px == 0; }));
}

TEST_F(ImageAuditTest, FindsACrack) {
  change_all([](codec::TileMesh& mesh) {
    // Every triangle in a square of the tile's middle.
    const auto [low, high] = std::ranges::minmax(mesh.vertices, {}, &codec::GridVertex::x);
    const int third = (high.x - low.x) / 3;
    std::erase_if(mesh.triangles, [&](const codec::Triangle& t) {
      return std::ranges::all_of(t, [&](std::uint32_t v) {
        const codec::GridVertex& p = mesh.vertices[v];
        return p.x >= third && p.x <= 2 * third && p.y >= third && p.y <= 2 * third;
      });
    });
  });
  audit();
  EXPECT_TRUE(is_found("background is seen through the terrain"));
}

TEST_F(ImageAuditTest, FindsAnUnderstatedError) {
  // A viewer that trusts these figures draws the root from anywhere.
  for (cache::StoredTile& tile : tree_.tiles) tile.info.error_m = tile.info.border_error_m = 0;
  audit();
  EXPECT_TRUE(is_found("off by"));
}

}  // namespace
}  // namespace tintree::audit
