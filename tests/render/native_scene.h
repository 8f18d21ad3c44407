#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "cache/tile_store.h"
#include "codec/mesh_codec.h"
#include "render/picking.h"
#include "render/terrain_scene.h"
#include "tests/render/osmesa_test.h"
#include "tests/render/seen.h"
#include "tests/render/write_tree.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {

/// An analytic tree (`Tree`) of a method whose tiles are not drawn as meshes, as a scene under OSMesa, beside the same
/// meshes as a tree of method `tin`.
template <typename Tree>
class NativeSceneTest : public OsMesaTest {
 protected:
  enum Kind : std::size_t { kMeshes, kNative };

  NativeSceneTest(int width_px, int height_px)
      : target_(std::move(*OffscreenTarget::create(gl_, width_px, height_px, 1))) {}

  /// Ends before the raster's tiles do, and has a hole.
  void cut_short() {
    tree_.columns = 121;
    tree_.hole = [](double x, double y) { return std::hypot(x - 500, y + 500) < 90; };
  }
  void texture() {
    tree_.color = [](const codec::TileId& id) -> std::array<std::uint8_t, 3> {
      return {static_cast<std::uint8_t>(60 * id.level), static_cast<std::uint8_t>(40 * id.x), 200};
    };
  }
  /// Writes both trees and opens them.
  void write(const std::string& method, const codec::MeshCodec& codec, const test::NormalAt& normals = nullptr) {
    const std::array paths{dir_.file("mesh.tintree"), dir_.file(method + ".tintree")};
    test::write_tree(paths[kMeshes], "tin", *codec::find_codec("tin"), tree_, normals);
    test::write_tree(paths[kNative], method, codec, tree_, normals);
    for (const std::string& path : paths) stores_.push_back(std::move(*cache::TileStore::open(path)));
  }

  std::unique_ptr<TerrainScene> open(Kind kind, const SceneOptions& options = {}) {
    auto made = TerrainScene::create(functions_, stores_[kind], options);
    EXPECT_TRUE(made) << made.error().text();
    return std::move(*made);
  }

  /// Lower and nearer from view to view.
  Camera view(int i) const {
    const glm::dvec3 eye(300 + 120 * i, -1500 + 190 * i, 500 - 85 * i);
    Camera c = test::camera_at(eye, eye + glm::dvec3(100 - 30 * i, 260, -170 + 8 * i), target_.width_px(),
                               target_.height_px());
    c.fov_y_rad = 0.8;
    return c;
  }
  std::vector<Camera> views() const { return {view(0), view(2), view(4)}; }

  test::Seen draw(TerrainScene& scene, const Camera& camera) const {
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

  void looks_like_its_meshes(TerrainScene& meshes, TerrainScene& natives) const {
    for (const Camera& c : views()) {
      const test::Seen a = draw(meshes, c);
      const test::Seen b = draw(natives, c);
      EXPECT_EQ(a.stats.triangles, b.stats.triangles);
      EXPECT_EQ(a.stats.tiles, b.stats.tiles);
      EXPECT_TRUE(test::look_alike(a, b, c));
    }
  }

  /// `gpu_bytes`: too little for all that view(2) needs.
  void takes_its_place_in_the_memory(SceneOptions options, std::size_t gpu_bytes) {
    const std::uint64_t all = draw(*open(kNative, options), view(2)).stats.triangles;
    options.gpu_bytes = gpu_bytes;
    const auto scene = open(kNative, options);
    std::uint64_t drawn = 0;
    for (const Camera& c : views()) {
      const test::Seen seen = draw(*scene, c);
      if (c.eye == view(2).eye) drawn = seen.stats.triangles;
      EXPECT_LE(scene->pool().reserved_bytes(), gpu_bytes);
      EXPECT_LE(scene->pool().bytes(), gpu_bytes);
    }
    EXPECT_GT(drawn, 0U);
    EXPECT_LT(drawn, all);
  }

  /// `shape`: what the tree's tiles have in place of vertices.
  template <typename Shape>
  void is_picked_like_its_meshes(Shape cache::NativeGround::*shape, const SceneOptions& options = {}) {
    const auto meshes = open(kMeshes, options);
    const auto natives = open(kNative, options);
    int hits = 0;
    for (const codec::TileId& id : tree_.tiles()) {
      const auto mesh = load(*meshes, id);
      const auto native = load(*natives, id);
      ASSERT_TRUE(mesh && native && native->native.*shape && !mesh->native.is_there());
      EXPECT_TRUE(native->vertices.empty());
      EXPECT_LT(native->bytes(), mesh->bytes());
      for (int i = 0; i < 40; ++i) {
        const Ray ray{{33.3 * i, -7.0 - 31 * ((7 * i) % 41), 400}, {0.1, 0.2 - 0.01 * i, -1}};
        const auto a = first_hit(*mesh, ray);
        const auto b = first_hit(*native, ray);
        ASSERT_EQ(a.has_value(), b.has_value()) << id.text() << ' ' << i;
        if (!a) continue;
        ++hits;
        EXPECT_NEAR(*a, *b, 1e-9 * *a);
      }
    }
    EXPECT_GT(hits, 20);
  }

  Tree tree_;
  test::TempDir dir_;
  GlFunctions functions_ = gl_;  ///< What scenes are drawn by.
  std::vector<cache::TileStore> stores_;
  OffscreenTarget target_;
  Style style_{.background = glm::vec3(1, 0, 1)};
};

}  // namespace tintree::render
