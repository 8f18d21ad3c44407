/// Trees of method `scalar` as scenes under OSMesa, dequantised by the card, against the same meshes drawn as meshes.

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "codec/scalar_codec.h"
#include "render/picking.h"
#include "render/scalar_placement.h"
#include "render/terrain_scene.h"
#include "tests/render/osmesa_test.h"
#include "tests/render/scalar_tree.h"
#include "tests/render/seen.h"
#include "tests/render/write_tree.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

constexpr int kWidth = 120;
constexpr int kHeight = 90;

/// Not what the ground says.
std::array<float, 3> ripples(double x, double y) {
  const glm::vec3 n = glm::normalize(glm::vec3(0.5 * std::sin(x / 37), 0.5 * std::cos(y / 29), 1));
  return {n.x, n.y, n.z};
}

struct Case {
  const char* name;
  bool table;
  bool cut_short;  ///< By the raster's end, and with a hole.
  bool textured;
  bool normal_mapped;
};

class ScalarSceneTest : public OsMesaTest, public testing::WithParamInterface<Case> {
 protected:
  void SetUp() override {
    const Case& c = GetParam();
    tree_.table = c.table;
    if (c.cut_short) {
      tree_.columns = 121;
      tree_.hole = [](double x, double y) { return std::hypot(x - 500, y + 500) < 90; };
    }
    if (c.textured)
      tree_.color = [](const codec::TileId& id) -> std::array<std::uint8_t, 3> {
        return {static_cast<std::uint8_t>(60 * id.level), static_cast<std::uint8_t>(40 * id.x), 200};
      };
    const test::NormalAt normals = c.normal_mapped ? ripples : test::NormalAt();
    test::write_tree(dir_.file("mesh.tintree"), "tin", *codec::find_codec("tin"), tree_, normals);
    test::write_tree(dir_.file("scalar.tintree"), "scalar", codec::ScalarCodec(), tree_, normals);
    for (const char* name : {"mesh.tintree", "scalar.tintree"})
      stores_.push_back(std::move(*cache::TileStore::open(dir_.file(name))));
  }

  std::unique_ptr<TerrainScene> open(std::size_t which, const SceneOptions& options = {}) {
    auto made = TerrainScene::create(gl_, stores_[which], options);
    EXPECT_TRUE(made) << made.error().text();
    return std::move(*made);
  }

  static Camera view(int i) {
    Camera c;
    c.eye = {300 + 120 * i, -1500 + 190 * i, 500 - 85 * i};
    c.target = c.eye + glm::dvec3(100 - 30 * i, 260, -170 + 8 * i);
    c.width_px = kWidth;
    c.height_px = kHeight;
    c.fov_y_rad = 0.8;
    return c;
  }
  static std::vector<Camera> views() { return {view(0), view(2), view(4)}; }

  test::Seen draw(TerrainScene& scene, const Camera& camera) {
    test::Seen out = test::see(scene, target_, camera, style_);
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    return out;
  }

  static std::shared_ptr<const cache::DrawableTile> load(TerrainScene& scene, const codec::TileId& id) {
    const cache::TileRef ref{id, 0};
    scene.cache().request({&ref, 1});
    scene.cache().wait_idle();
    return scene.cache().get(ref);
  }

  test::ScalarTree tree_;
  test::TempDir dir_;
  std::vector<cache::TileStore> stores_;
  OffscreenTarget target_ = std::move(*OffscreenTarget::create(gl_, kWidth, kHeight, 1));
  Style style_{.background = glm::vec3(1, 0, 1)};
};

TEST_P(ScalarSceneTest, LooksLikeItsMeshes) {
  SceneOptions options;
  for (const double pixel_error : {2.0, 0.0}) {
    options.cut.pixel_error = pixel_error;
    const auto meshes = open(0, options);
    const auto grids = open(1, options);
    ASSERT_TRUE(grids->pool().has_scalars());
    for (const Camera& c : views()) {
      const test::Seen a = draw(*meshes, c);
      const test::Seen b = draw(*grids, c);
      EXPECT_EQ(a.stats.triangles, b.stats.triangles);
      EXPECT_EQ(a.stats.tiles, b.stats.tiles);
      EXPECT_TRUE(test::look_alike(a, b, c));
    }
  }
}

TEST_P(ScalarSceneTest, TakesItsPlaceInTheMemory) {
  SceneOptions options;
  options.cut.pixel_error = 0;
  const std::uint64_t all = draw(*open(1, options), view(2)).stats.triangles;
  options.gpu_bytes = std::size_t{48} << 10;
  const auto scene = open(1, options);
  std::uint64_t drawn = 0;
  for (const Camera& c : views()) {
    const test::Seen seen = draw(*scene, c);
    if (c.eye == view(2).eye) drawn = seen.stats.triangles;
    EXPECT_LE(scene->pool().reserved_bytes(), options.gpu_bytes);
    EXPECT_LE(scene->pool().bytes(), options.gpu_bytes);
  }
  EXPECT_GT(drawn, 0U);
  EXPECT_LT(drawn, all);
}

TEST_P(ScalarSceneTest, IsPickedLikeItsMeshes) {
  const auto meshes = open(0);
  const auto grids = open(1);
  int hits = 0;
  for (const codec::TileId& id : tree_.tiles()) {
    const auto mesh = load(*meshes, id);
    const auto grid = load(*grids, id);
    ASSERT_TRUE(mesh && grid && grid->native.scalar && !mesh->native.is_there());
    EXPECT_TRUE(grid->vertices.empty());
    EXPECT_LT(grid->bytes(), mesh->bytes());
    for (int i = 0; i < 40; ++i) {
      const Ray ray{{33.3 * i, -7.0 - 31 * ((7 * i) % 41), 400}, {0.1, 0.2 - 0.01 * i, -1}};
      const auto a = first_hit(*mesh, ray);
      const auto b = first_hit(*grid, ray);
      ASSERT_EQ(a.has_value(), b.has_value()) << id.text() << ' ' << i;
      if (!a) continue;
      ++hits;
      EXPECT_NEAR(*a, *b, 1e-9 * *a);
    }
  }
  EXPECT_GT(hits, 20);
}

TEST_P(ScalarSceneTest, HasItsMeshesVerticesByThePayloadsQuantizer) {
  const auto grids = open(1);
  std::size_t tables = 0;
  for (const codec::TileId& id : tree_.tiles()) {
    const auto tile = load(*grids, id);
    const auto decoded = stores_[1].read_mesh(id);
    ASSERT_TRUE(tile && tile->native.scalar && decoded && decoded->height_quantizer) << id.text();
    const cache::QuantizedShape& shape = *tile->native.scalar;
    EXPECT_EQ(shape.table, decoded->height_quantizer->table);
    EXPECT_EQ(shape.format.low, decoded->height_quantizer->low);
    EXPECT_EQ(shape.format.step, decoded->height_quantizer->step);
    tables += shape.table.empty() ? 0 : 1;
    const codec::TileMesh mesh = tree_.mesh(id);
    ASSERT_GE(shape.words.size(), mesh.vertices.size());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
      ASSERT_EQ(shape.vertex(shape.words[i]), mesh.vertices[i]) << id.text() << ' ' << i;
  }
  if (GetParam().table) {
    EXPECT_GT(tables, 0U);
  } else {
    EXPECT_LT(tables, tree_.tiles().size());
  }
}

/// As the shader computes positions: in single floats, from the eye.
TEST_P(ScalarSceneTest, NeighboursShareTheirSidesBitForBit) {
  const auto grids = open(1);
  const std::array<double, 3> eye{417.3, -611.9, 87.7};
  std::map<std::tuple<int, std::int64_t, std::int64_t>, std::array<std::uint32_t, 3>> seen;
  std::size_t shared = 0;
  for (const codec::TileId& id : tree_.tiles()) {
    const auto tile = load(*grids, id);
    const cache::QuantizedShape& shape = *tile->native.scalar;
    const ScalarPlacement at = place_scalar(tile->frame, shape.format, eye);
    for (const std::uint32_t word : shape.words) {
      const codec::GridVertex v = shape.vertex(word);
      if (!shape.format.on_side(v.x, v.y)) continue;
      const glm::vec3 p(at.lattice_to_eye * glm::vec4(at.on_lattice({v.x, v.y, v.z}), 1));
      const std::array bits{std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                            std::bit_cast<std::uint32_t>(p.z)};
      const auto [column, row] = std::pair{tile->frame.column0 + (std::int64_t{v.x} << tile->frame.xy_shift),
                                           tile->frame.row0 + (std::int64_t{v.y} << tile->frame.xy_shift)};
      const auto [first, added] = seen.try_emplace({id.level, column, row}, bits);
      shared += added ? 0 : 1;
      ASSERT_EQ(first->second, bits) << id.text() << ": " << column << ", " << row;
    }
  }
  EXPECT_GT(shared, 200U);
}

TEST_P(ScalarSceneTest, MorphsAsMeshes) {
  SceneOptions options;
  options.cut = {.pixel_error = 2, .morph = true};
  const auto scene = open(1, options);
  EXPECT_FALSE(scene->pool().has_scalars());
  EXPECT_GT(draw(*scene, view(2)).stats.triangles, 0U);
}

TEST_P(ScalarSceneTest, WhatIsHiddenChangesNothing) {
  std::vector<Picture> whole;
  for (const Occlusion occlusion : {Occlusion::kOff, Occlusion::kAlways}) {
    SceneOptions options;
    options.occlusion = occlusion;
    const auto scene = open(1, options);
    for (int i = 0; i < 3; ++i) {
      Camera c = view(2);
      c.eye = {150 + 400 * i, -1250, tree_.height_m(150 + 400 * i, -1250) + 4};
      c.target = c.eye + glm::dvec3(30 - 20 * i, 300, -12);
      const Picture picture = draw(*scene, c).picture;
      if (occlusion == Occlusion::kOff) {
        whole.push_back(picture);
      } else {
        EXPECT_EQ(picture.rgb, whole[static_cast<std::size_t>(i)].rgb) << i;
      }
    }
  }
}

/// A slow flight towards far ground, a picture of which is drawn in its place.
TEST_P(ScalarSceneTest, ImpostorsLookLikeThoseOfItsMeshes) {
  SceneOptions options;
  options.impostors = true;
  const auto meshes = open(0, options);
  const auto grids = open(1, options);
  int replaced = 0;
  constexpr int kFrames = 4;
  // The picture is drawn first, over several frames.
  for (int i = -impostor::kMostDrawing; i < kFrames; ++i) {
    Camera c = view(0);
    c.eye = {100 + 0.03 * i, -1200 + 0.02 * i, 160};
    c.target = c.eye + glm::dvec3(900, 700 + 20 * std::sin(0.2 * i), -200);
    const test::Seen seen = draw(*grids, c);
    const test::Seen plain = draw(*meshes, c);
    if (i < 0) continue;
    replaced += seen.stats.impostor_tiles > 0 ? 1 : 0;
    EXPECT_TRUE(test::look_alike(seen, plain, c)) << i;
  }
  EXPECT_EQ(replaced, kFrames);
}

INSTANTIATE_TEST_SUITE_P(Trees, ScalarSceneTest,
                         testing::Values(Case{"Uniform", false, false, false, false},
                                         Case{"LloydMaxNormalMapped", true, false, false, true},
                                         Case{"HoledCutShort", false, true, false, false},
                                         Case{"TexturedLloydMax", true, false, true, false}),
                         [](const auto& c) { return std::string(c.param.name); });

}  // namespace
}  // namespace tintree::render
