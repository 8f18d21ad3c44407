/// Strips and nested tiles under OSMesa as all tiles may be: lit by normal maps, behind impostors, beside trees of
/// other methods; against the same meshes drawn as meshes.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codec/nested_mesh.h"
#include "codec/strip_mesh.h"
#include "render/terrain_scene.h"
#include "tests/render/osmesa_test.h"
#include "tests/render/quadtree_tree.h"
#include "tests/render/seen.h"
#include "tests/render/write_tree.h"
#include "tests/support/nested_tree.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

using test::NestedTree;

constexpr int kWidth = 120;
constexpr int kHeight = 90;
/// Depths at the rims of nested tiles are rounded otherwise than those of their meshes: so many pixels of a picture.
constexpr std::size_t kMostRim = 1;
constexpr double kAcross_m = 256 * NestedTree::kSpacing_m;

/// One ground in three trees side by side: nested in the north-west, strips in the north-east, meshes in the south.
class NativeGroundTest : public OsMesaTest {
 protected:
  using Stores = std::vector<const cache::TileStore*>;

  /// `east`, `south`: how many trees' widths from the first.
  static test::QuadtreeTree quadtree(int east, int south) {
    test::QuadtreeTree out;
    out.columns = east == 0 ? 257 : 129;
    out.spacing_m = kAcross_m / 128;
    out.height_m = [=](double x, double y) {
      return NestedTree::ground_m(x + east * kAcross_m, y - south * kAcross_m);
    };
    return out;
  }

  template <typename Tree>
  const cache::TileStore* store(const std::string& method, const Tree& tree, int east, int south, bool normal_maps) {
    const std::string path = dir_.file(std::to_string(stores_.size()) + ".tintree");
    const double step_m = tree.layout().dx_m;
    test::write_tree(path, method, *codec::find_codec(method), tree, normal_maps ? test::ripples : test::NormalAt(),
                     {east * kAcross_m - step_m / 2, step_m, 0, -south * kAcross_m + step_m / 2, 0, -step_m});
    stores_.push_back(std::make_unique<cache::TileStore>(std::move(*cache::TileStore::open(path))));
    return stores_.back().get();
  }
  /// The nested tree or the strips, or the same meshes as a tree of meshes.
  const cache::TileStore* one(bool nested, bool native, bool normal_maps = false) {
    return nested ? store(native ? "nested" : "tin", NestedTree(), 0, 0, normal_maps)
                  : store(native ? "strip" : "tin", quadtree(1, 0), 1, 0, normal_maps);
  }
  Stores all(bool native) { return {one(true, native), one(false, native), store("tin", quadtree(0, 1), 0, 1, false)}; }

  static std::unique_ptr<TerrainScene> scene(const Stores& stores, const SceneOptions& options) {
    auto made = TerrainScene::create(gl_, stores, options);
    EXPECT_TRUE(made) << made.error().text();
    return std::move(*made);
  }
  static SceneOptions finest() {
    SceneOptions out;
    out.cut.pixel_error = 0;
    return out;
  }

  test::Seen see(TerrainScene& scene, const Camera& camera) {
    test::Seen out = test::see(scene, target_, camera, style_);
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    return out;
  }

  /// From the air, over the corner where the trees meet.
  static std::vector<Camera> views() {
    std::vector<Camera> out;
    for (int i = 0; i < 4; ++i) {
      Camera c;
      c.eye = {kAcross_m - 260 + 40 * i, -700 - 90 * i, 420 - 60 * i};
      c.target = c.eye + glm::dvec3(130 - 50 * i, -170 + 25 * i, -190);
      c.width_px = kWidth;
      c.height_px = kHeight;
      c.fov_y_rad = 0.8;
      out.push_back(c);
    }
    return out;
  }

  int open_px(const test::Seen& seen) const { return test::count_color(seen.picture, {255, 0, 255}); }

  test::TempDir dir_;
  std::vector<std::unique_ptr<cache::TileStore>> stores_;
  OffscreenTarget target_ = std::move(*OffscreenTarget::create(gl_, kWidth, kHeight, 1));
  Style style_{.background = glm::vec3(1, 0, 1)};
};

TEST_F(NativeGroundTest, IsLitByNormalMapsAsMeshesAre) {
  for (const bool nested : {true, false}) {
    const auto native = scene({one(nested, true, true)}, finest());
    const auto meshes = scene({one(nested, false, true)}, finest());
    const auto without = scene({one(nested, false, false)}, finest());
    for (Camera c : views()) {
      const double aside = nested ? -300 : 400 - kAcross_m;  // A tree by itself begins at 0.
      c.eye.x += aside;
      c.target.x += aside;
      const test::Seen seen = see(*native, c);
      const std::size_t most_rim = nested ? kMostRim : 0;
      EXPECT_TRUE(test::look_alike(seen, see(*meshes, c), c, most_rim)) << nested;
      EXPECT_FALSE(test::look_alike(seen, see(*without, c), c, most_rim)) << nested;
    }
  }
}

TEST_F(NativeGroundTest, ThreeMethodsInOneSceneLookLikeMeshes) {
  const auto mixed = scene(all(true), finest());
  const auto meshes = scene(all(false), finest());
  for (const Camera& c : views()) {
    const test::Seen seen = see(*mixed, c);
    EXPECT_TRUE(test::look_alike(seen, see(*meshes, c), c));
    EXPECT_EQ(open_px(seen), 0);
  }
}

/// By coarser levels, each tree's own, with what joins them.
TEST_F(NativeGroundTest, NoGapOpensBetweenMethods) {
  const Stores trees = all(true);
  int open = 0;
  for (const bool morph : {false, true}) {
    for (const double pixel_error : {2.0, 6.0}) {
      SceneOptions options;
      options.cut = {.pixel_error = pixel_error, .morph = morph};
      const auto mixed = scene(trees, options);
      for (const Camera& c : views()) {
        style_.skirts = true;
        EXPECT_EQ(open_px(see(*mixed, c)), 0) << pixel_error << ", morph " << morph;
        style_.skirts = false;
        open += open_px(see(*mixed, c));
      }
    }
  }
  EXPECT_GT(open, 0) << "there was nothing to join";
}

/// From low over the ground, where hills stand before hills.
TEST_F(NativeGroundTest, WhatIsHiddenChangesNothing) {
  const Stores trees = all(true);
  std::uint32_t hidden = 0;
  std::vector<Picture> whole;
  for (const Occlusion occlusion : {Occlusion::kOff, Occlusion::kAlways}) {
    SceneOptions options;
    options.occlusion = occlusion;
    const auto mixed = scene(trees, options);
    for (int i = 0; i < 6; ++i) {
      Camera c = views()[0];
      c.eye = {200 + 400 * i, -1250 + 90 * i, 0};
      c.eye.z = NestedTree::ground_m(c.eye.x, c.eye.y) + 4;
      c.target = c.eye + glm::dvec3(30 - 20 * i, 300, -12);
      c.fov_y_rad = 0.4;
      const auto cut = mixed->settle(c);
      ASSERT_TRUE(cut);
      mixed->draw(target_, c, *cut, style_);
      hidden += cut->occluded;
      if (occlusion == Occlusion::kOff) {
        whole.push_back(target_.read_picture());
      } else {
        EXPECT_EQ(target_.read_picture().rgb, whole[static_cast<std::size_t>(i)].rgb) << i;
      }
    }
  }
  EXPECT_GT(hidden, 0U) << "nothing was hidden";
}

/// Drawn in parts or at once, tiles and what joins them are the same to the last bit of colour and depth.
TEST_F(NativeGroundTest, PartsOfACutMakeTheSamePicture) {
  const auto mixed = scene(all(true), finest());
  auto strips = StripUnpacker::create(gl_, GpuPages::kLargestPage);
  ASSERT_TRUE(strips);
  constexpr std::size_t kBytes = std::size_t{64} << 20;
  GpuTilePool pool(gl_, {.mesh_bytes = kBytes, .picture_bytes = kBytes, .nested_bytes = kBytes},
                   {.reliefs = nullptr, .strips = std::move(*strips), .scalars = nullptr});
  for (const Camera& c : views()) {
    const auto cut = mixed->settle(c);
    ASSERT_TRUE(cut);
    for (const DrawTile& d : cut->draws) {
      const cache::TileRef tile{mixed->trees()[d.tree]->nodes()[d.node].id, d.tree};
      ASSERT_TRUE(pool.contains(tile) || pool.upload(tile, *mixed->cache().get(tile)));
    }
    std::array<Picture, 2> pictures;
    std::array<std::vector<float>, 2> depths;
    for (const std::size_t way : {0, 1}) {
      const std::size_t size = way == 0 ? cut->draws.size() : 2;
      mixed->renderer().draw_background(target_, c, style_);
      for (std::span<const DrawTile> rest(cut->draws); !rest.empty();) {
        const auto part = rest.first(std::min(size, rest.size()));
        mixed->renderer().draw_ground(c, mixed->trees(), *cut, part, pool, style_);
        rest = rest.subspan(part.size());
      }
      pictures[way] = target_.read_picture();
      depths[way] = target_.read_depths();
    }
    EXPECT_EQ(pictures[0].rgb, pictures[1].rgb);
    EXPECT_EQ(depths[0], depths[1]);
    EXPECT_EQ(test::count_color(pictures[1], {255, 0, 255}), 0);
  }
}

/// A slow flight towards far ground, a picture of which is drawn in its place.
TEST_F(NativeGroundTest, ImpostorsShowWhatMeshesWould) {
  for (const int which : {0, 1, 2}) {
    const auto trees = [&](bool native) { return which == 2 ? all(native) : Stores{one(which == 0, native)}; };
    const auto plain = scene(trees(false), {});
    SceneOptions options;
    options.impostors = true;
    const auto with = scene(trees(true), options);
    int replaced = 0, strange = 0;
    constexpr int kFrames = 8;
    // The picture is drawn first, over several frames.
    for (int i = -impostor::kMostDrawing; i < kFrames; ++i) {
      Camera c = views()[0];
      c.eye = {(which == 1 ? 100 : 150) + 0.03 * i, -1200 + 0.02 * i, 160};
      c.target = c.eye + glm::dvec3(900, 700 + 20 * std::sin(0.2 * i), -200);
      const test::Seen a = see(*with, c);
      if (i < 0) continue;
      replaced += a.stats.impostor_tiles > 0 ? 1 : 0;
      strange += test::count_strange(a.picture, see(*plain, c).picture, 24);
    }
    EXPECT_EQ(replaced, kFrames) << which;
    EXPECT_LT(strange, kFrames * kWidth * kHeight / 2000) << which;
  }
}

TEST_F(NativeGroundTest, TheMethodsShareTheMemory) {
  const Stores trees = all(true);
  std::uint64_t most = 0;
  for (const std::size_t bytes : {std::size_t{64} << 20, std::size_t{2} << 20}) {
    SceneOptions options = finest();
    options.gpu_bytes = bytes;
    const auto mixed = scene(trees, options);
    std::uint64_t drawn = 0;
    for (const Camera& c : views()) {
      const test::Seen seen = see(*mixed, c);
      EXPECT_EQ(open_px(seen), 0) << bytes;
      EXPECT_LE(mixed->pool().reserved_bytes(), bytes);
      drawn += seen.stats.triangles;
    }
    EXPECT_TRUE(most == 0 || drawn < most) << "everything found room";
    most = std::max(most, drawn);
  }
}

}  // namespace
}  // namespace tintree::render
