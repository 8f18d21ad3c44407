/// Trees of method `strip` as scenes under OSMesa, unpacked by the card, against the same meshes drawn as meshes.

#include <cstddef>
#include <string>

#include <gtest/gtest.h>

#include "codec/coded_strip_mesh.h"
#include "codec/strip_mesh.h"
#include "tests/render/native_scene.h"
#include "tests/render/quadtree_tree.h"

namespace tintree::render {
namespace {

struct Case {
  const char* name;
  bool coded;
  bool compute;
  bool cut_short;  ///< By the raster's end, and with a hole.
  bool textured;
  int levels_per_doubling;
};

class StripSceneTest : public NativeSceneTest<test::QuadtreeTree>, public testing::WithParamInterface<Case> {
 protected:
  StripSceneTest() : NativeSceneTest(200, 150) {}

  void SetUp() override {
    const Case& c = GetParam();
    tree_.levels_per_doubling = c.levels_per_doubling;
    if (c.cut_short) cut_short();
    if (c.textured) texture();
    if (c.coded) {
      write("strip", codec::CodedStripMesh());
    } else {
      write("strip", codec::StripMesh());
    }
    if (!c.compute) functions_.DispatchCompute = nullptr;
  }

  static SceneOptions at_two_pixels(bool morph = false) {
    SceneOptions out;
    out.cut = {.pixel_error = 2, .morph = morph};
    return out;
  }
};

TEST_P(StripSceneTest, LooksLikeItsMeshes) {
  const auto strips = open(kNative, at_two_pixels());
  ASSERT_TRUE(strips->pool().has_strips());
  looks_like_its_meshes(*open(kMeshes, at_two_pixels()), *strips);
}

TEST_P(StripSceneTest, TakesItsPlaceInTheMemory) {
  takes_its_place_in_the_memory(at_two_pixels(), std::size_t{96} << 10);
}

TEST_P(StripSceneTest, IsPickedLikeItsMeshes) {
  is_picked_like_its_meshes(&cache::NativeGround::strip, at_two_pixels());
}

TEST_P(StripSceneTest, MorphsAsMeshes) {
  const auto scene = open(kNative, at_two_pixels(true));
  EXPECT_FALSE(scene->pool().has_strips());
  EXPECT_GT(draw(*scene, view(2)).stats.triangles, 0U);
}

INSTANTIATE_TEST_SUITE_P(Trees, StripSceneTest,
                         testing::Values(Case{"Plain", false, true, false, false, 1},
                                         Case{"Feedback", false, false, true, false, 1},
                                         Case{"CodedCutShort", true, true, true, false, 1},
                                         Case{"TexturedHalfSteps", true, true, false, true, 2}),
                         [](const auto& c) { return std::string(c.param.name); });

}  // namespace
}  // namespace tintree::render
