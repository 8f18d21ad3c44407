/// Trees of method `strip` as scenes under OSMesa, unpacked by the card, against the same meshes drawn as meshes.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codec/coded_strip_mesh.h"
#include "codec/strip_mesh.h"
#include "render/picking.h"
#include "render/terrain_scene.h"
#include "tests/render/osmesa_test.h"
#include "tests/render/quadtree_tree.h"
#include "tests/render/seen.h"
#include "tests/render/write_tree.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 150;

struct Case {
  const char* name;
  bool coded;
  bool compute;
  bool cut_short;  ///< By the raster's end, and with a hole.
  bool textured;
  int levels_per_doubling;
};

class StripSceneTest : public OsMesaTest, public testing::WithParamInterface<Case> {
 protected:
  void SetUp() override {
    const Case& c = GetParam();
    tree_.levels_per_doubling = c.levels_per_doubling;
    if (c.cut_short) {
      tree_.columns = 121;
      tree_.hole = [](double x, double y) { return std::hypot(x - 500, y + 500) < 90; };
    }
    if (c.textured)
      tree_.color = [](const codec::TileId& id) -> std::array<std::uint8_t, 3> {
        return {static_cast<std::uint8_t>(60 * id.level), static_cast<std::uint8_t>(40 * id.x), 200};
      };
    test::write_tree(dir_.file("mesh.tintree"), "tin", *codec::find_codec("tin"), tree_);
    const codec::StripMesh packed;
    const codec::CodedStripMesh coded;
    const codec::MeshCodec& codec =
        c.coded ? static_cast<const codec::MeshCodec&>(coded) : static_cast<const codec::MeshCodec&>(packed);
    test::write_tree(dir_.file("strip.tintree"), "strip", codec, tree_);
    functions_ = gl_;
    if (!c.compute) functions_.DispatchCompute = nullptr;
    for (const char* name : {"mesh.tintree", "strip.tintree"})
      stores_.push_back(std::move(*cache::TileStore::open(dir_.file(name))));
    target_.emplace(std::move(*OffscreenTarget::create(gl_, kWidth, kHeight, 1)));
    style_.background = glm::vec3(1, 0, 1);
  }

  std::unique_ptr<TerrainScene> open(std::size_t which, bool morph = false,
                                     std::size_t gpu_bytes = std::size_t{64} << 20) {
    SceneOptions options;
    options.cut = {.pixel_error = 2, .morph = morph};
    options.gpu_bytes = gpu_bytes;
    auto made = TerrainScene::create(functions_, stores_[which], options);
    EXPECT_TRUE(made) << made.error().text();
    return std::move(*made);
  }

  static std::vector<Camera> views() {
    std::vector<Camera> out;
    for (int i = 0; i < 5; i += 2) {
      Camera c;
      c.eye = {300 + 120 * i, -1500 + 190 * i, 500 - 85 * i};
      c.target = c.eye + glm::dvec3(100 - 30 * i, 260, -170 + 8 * i);
      c.width_px = kWidth;
      c.height_px = kHeight;
      c.fov_y_rad = 0.8;
      out.push_back(c);
    }
    return out;
  }

  test::Seen draw(TerrainScene& scene, const Camera& camera) {
    test::Seen out = test::see(scene, *target_, camera, style_);
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    return out;
  }

  test::QuadtreeTree tree_;
  test::TempDir dir_;
  GlFunctions functions_;
  std::vector<cache::TileStore> stores_;
  std::optional<OffscreenTarget> target_;
  Style style_;
};

TEST_P(StripSceneTest, LooksLikeItsMeshes) {
  const auto meshes = open(0);
  const auto strips = open(1);
  ASSERT_TRUE(strips->pool().has_strips());
  for (const Camera& c : views()) {
    const test::Seen a = draw(*meshes, c);
    const test::Seen b = draw(*strips, c);
    EXPECT_EQ(a.stats.triangles, b.stats.triangles);
    EXPECT_EQ(a.stats.tiles, b.stats.tiles);
    EXPECT_TRUE(test::look_alike(a, b, c));
  }
}

TEST_P(StripSceneTest, TakesItsPlaceInTheMemory) {
  const std::uint64_t all = draw(*open(1), views()[1]).stats.triangles;
  constexpr std::size_t kBytes = std::size_t{96} << 10;
  const auto scene = open(1, false, kBytes);
  std::uint64_t drawn = 0;
  for (const Camera& c : views()) {
    const test::Seen seen = draw(*scene, c);
    if (c.eye == views()[1].eye) drawn = seen.stats.triangles;
    EXPECT_LE(scene->pool().reserved_bytes(), kBytes);
    EXPECT_LE(scene->pool().bytes(), kBytes);
  }
  EXPECT_GT(drawn, 0U);
  EXPECT_LT(drawn, all);
}

TEST_P(StripSceneTest, IsPickedLikeItsMeshes) {
  const auto meshes = open(0);
  const auto strips = open(1);
  int hits = 0;
  for (const codec::TileId& id : tree_.tiles()) {
    for (TerrainScene* scene : {meshes.get(), strips.get()}) {
      const cache::TileRef ref{id, 0};
      scene->cache().request({&ref, 1});
      scene->cache().wait_idle();
    }
    const auto mesh = meshes->cache().get({id, 0});
    const auto strip = strips->cache().get({id, 0});
    ASSERT_TRUE(mesh && strip && strip->native.strip && !mesh->native.is_there());
    EXPECT_TRUE(strip->vertices.empty());
    EXPECT_LT(strip->bytes(), mesh->bytes());
    for (int i = 0; i < 40; ++i) {
      const Ray ray{{33.3 * i, -7.0 - 31 * ((7 * i) % 41), 400}, {0.1, 0.2 - 0.01 * i, -1}};
      const auto a = first_hit(*mesh, ray);
      const auto b = first_hit(*strip, ray);
      ASSERT_EQ(a.has_value(), b.has_value()) << id.text() << ' ' << i;
      if (!a) continue;
      ++hits;
      EXPECT_NEAR(*a, *b, 1e-9 * *a);
    }
  }
  EXPECT_GT(hits, 20);
}

TEST_P(StripSceneTest, MorphsAsMeshes) {
  const auto scene = open(1, true);
  EXPECT_FALSE(scene->pool().has_strips());
  EXPECT_GT(draw(*scene, views()[1]).stats.triangles, 0U);
}

INSTANTIATE_TEST_SUITE_P(Trees, StripSceneTest,
                         testing::Values(Case{"Plain", false, true, false, false, 1},
                                         Case{"Feedback", false, false, true, false, 1},
                                         Case{"CodedCutShort", true, true, true, false, 1},
                                         Case{"TexturedHalfSteps", true, true, false, true, 2}),
                         [](const auto& c) { return std::string(c.param.name); });

}  // namespace
}  // namespace tintree::render
