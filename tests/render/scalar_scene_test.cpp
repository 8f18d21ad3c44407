/// Trees of method `scalar` as scenes under OSMesa, dequantised by the card, against the same meshes drawn as meshes.

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "codec/scalar_codec.h"
#include "render/scalar_placement.h"
#include "tests/render/native_scene.h"
#include "tests/render/scalar_tree.h"

namespace tintree::render {
namespace {

struct Case {
  const char* name;
  bool table;
  bool cut_short;  ///< By the raster's end, and with a hole.
  bool textured;
  bool normal_mapped;
};

class ScalarSceneTest : public NativeSceneTest<test::ScalarTree>, public testing::WithParamInterface<Case> {
 protected:
  ScalarSceneTest() : NativeSceneTest(120, 90) {}

  void SetUp() override {
    const Case& c = GetParam();
    tree_.table = c.table;
    if (c.cut_short) cut_short();
    if (c.textured) texture();
    write("scalar", codec::ScalarCodec(), c.normal_mapped ? test::ripples : test::NormalAt());
  }
};

TEST_P(ScalarSceneTest, LooksLikeItsMeshes) {
  SceneOptions options;
  for (const double pixel_error : {2.0, 0.0}) {
    options.cut.pixel_error = pixel_error;
    const auto grids = open(kNative, options);
    ASSERT_TRUE(grids->pool().has_scalars());
    looks_like_its_meshes(*open(kMeshes, options), *grids);
  }
}

TEST_P(ScalarSceneTest, TakesItsPlaceInTheMemory) {
  SceneOptions options;
  options.cut.pixel_error = 0;
  takes_its_place_in_the_memory(options, std::size_t{48} << 10);
}

TEST_P(ScalarSceneTest, IsPickedLikeItsMeshes) { is_picked_like_its_meshes(&cache::NativeGround::scalar); }

TEST_P(ScalarSceneTest, HasItsMeshesVerticesByThePayloadsQuantizer) {
  const auto grids = open(kNative);
  std::size_t tables = 0;
  for (const codec::TileId& id : tree_.tiles()) {
    const auto tile = load(*grids, id);
    const auto decoded = stores_[kNative].read_mesh(id);
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
  const auto grids = open(kNative);
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
  const auto scene = open(kNative, options);
  EXPECT_FALSE(scene->pool().has_scalars());
  EXPECT_GT(draw(*scene, view(2)).stats.triangles, 0U);
}

TEST_P(ScalarSceneTest, WhatIsHiddenChangesNothing) {
  std::vector<Picture> whole;
  for (const Occlusion occlusion : {Occlusion::kOff, Occlusion::kAlways}) {
    SceneOptions options;
    options.occlusion = occlusion;
    const auto scene = open(kNative, options);
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
  const auto meshes = open(kMeshes, options);
  const auto grids = open(kNative, options);
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
