// Trees of method wavelet, drawn under OSMesa: lit by what their patches have beyond their meshes.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codec/wavelet_tiles.h"
#include "render/terrain_scene.h"
#include "tests/render/osmesa_test.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

constexpr int kCells = 16;
constexpr int kLeaf = 2;
constexpr int kSize = 200;

/// A flat mesh at every level, and patches of any heights in metres over columns and rows.
class FlatTree {
 public:
  explicit FlatTree(std::function<double(double, double)> height_m) : height_m_(std::move(height_m)) {
    layout_.columns = layout_.rows = (kCells << kLeaf) + 1;
    layout_.tile_cells = kCells;
    layout_.leaf_level = kLeaf;
    layout_.dx_m = layout_.dy_m = 10;
    layout_.leaf_error_m = 1;
    layout_.z_step_m = {0.5, 0.25, 0.125};
  }

  void write(const std::string& path) const {
    cache::Manifest manifest;
    manifest.method = "wavelet";
    manifest.criterion = "max";
    manifest.layout = layout_;
    auto writer = cache::TileWriter::create(path, manifest);
    ASSERT_TRUE(writer) << writer.error().text();
    put(*writer, {0, 0, 0}, nullptr);
    const auto digest = writer->finish();
    ASSERT_TRUE(digest) << digest.error().text();
  }

 private:
  codec::Patch target(const codec::TileId& id) const {
    codec::Patch out(kCells + 2 * codec::kPatchMargin, 0);
    const int shift = kLeaf - id.level;
    const auto place = [&](std::uint32_t tile, int i) {
      return std::ldexp(static_cast<double>(tile) * kCells + i - codec::kPatchMargin + 0.5, shift) - 0.5;
    };
    const double units = codec::kUnitsAStep / layout_.z_step_m[static_cast<std::size_t>(id.level)];
    for (int y = 0; y < out.side; ++y) {
      for (int x = 0; x < out.side; ++x) out.at(x, y) = std::llround(units * height_m_(place(id.x, x), place(id.y, y)));
    }
    return out;
  }

  /// 16 x 16 squares; diagonals alternate where they are larger than a cell.
  codec::TileMesh mesh(int level) const {
    codec::TileMesh out;
    out.xy_shift = kLeaf - level;
    constexpr std::int32_t kRow = kCells + 1;
    for (std::int32_t i = 0; i < kRow * kRow; ++i) out.vertices.push_back({i % kRow, i / kRow, 0});
    for (std::uint32_t y = 0; y < kCells; ++y) {
      for (std::uint32_t x = 0; x < kCells; ++x) {
        const std::uint32_t nw = y * kRow + x;
        const std::uint32_t sw = nw + kRow;
        if (level == kLeaf || (x + y) % 2 == 0) {
          out.triangles.insert(out.triangles.end(), {{nw, sw, sw + 1}, {nw, sw + 1, nw + 1}});
        } else {
          out.triangles.insert(out.triangles.end(), {{nw, sw, nw + 1}, {nw + 1, sw, sw + 1}});
        }
      }
    }
    return out;
  }

  void put(cache::TileWriter& writer, const codec::TileId& id, const codec::Patch* parent) const {
    codec::PatchSpec spec;
    spec.bound = 1;
    const auto patch = codec::encode_patch(target(id), codec::wavelet_prediction(layout_, id, parent), spec);
    ASSERT_TRUE(patch) << patch.error().text();
    const codec::TileMesh m = mesh(id.level);
    const auto payload = codec::encode_wavelet_tile(layout_, id, m, *patch);
    ASSERT_TRUE(payload) << payload.error().text();
    cache::TileInfo info;
    info.id = id;
    info.vertices = static_cast<std::uint32_t>(m.vertices.size());
    info.triangles = static_cast<std::uint32_t>(m.triangles.size());
    info.error_m = info.rms_m = 0.9 * layout_.bound_m(id.level);
    info.border_error_m = 0.4 * layout_.bound_m(id.level);
    const auto done = writer.put({info, *payload});
    ASSERT_TRUE(done) << done.error().text();
    for (unsigned quadrant = 0; id.level < kLeaf && quadrant < 4; ++quadrant)
      put(writer, {id.level + 1, 2 * id.x + (quadrant & 1), 2 * id.y + (quadrant >> 1)}, &patch->reconstruction);
  }

  std::function<double(double, double)> height_m_;
  codec::TreeLayout layout_;
};

class WaveletSceneTest : public OsMesaTest {
 protected:
  cache::TileStore tree(const std::function<double(double, double)>& height_m) {
    const std::string path = dir_.file("tree" + std::to_string(written_++) + ".tintree");
    FlatTree(height_m).write(path);
    return std::move(*cache::TileStore::open(path));
  }

  static std::unique_ptr<TerrainScene> scene(const cache::TileStore& store, const SceneOptions& options = {}) {
    auto made = TerrainScene::create(gl_, store, options);
    EXPECT_TRUE(made) << made.error().text();
    return std::move(*made);
  }

  /// Obliquely down upon the middle; the nearer, the finer.
  static Camera camera(double distance_m) {
    Camera c;
    c.target = {320, -320, 0};
    c.eye = {320, -320 - 0.8 * distance_m, 0.6 * distance_m};
    c.width_px = c.height_px = kSize;
    return c;
  }

  static LodCut settled(TerrainScene& scene, const Camera& camera) {
    auto cut = scene.settle(camera);
    EXPECT_TRUE(cut) << cut.error().text();
    return std::move(*cut);
  }

  /// Mean brightness of the picture's middle, and its root mean square deviation from that.
  static std::array<double, 2> light(TerrainScene& scene, const Camera& camera, const LodCut& cut) {
    const auto target = OffscreenTarget::create(gl_, kSize, kSize, 1);
    EXPECT_TRUE(target);
    scene.draw(*target, camera, cut, {});
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    const Picture picture = target->read_picture();
    double sum = 0;
    double squares = 0;
    int count = 0;
    for (int y = kSize / 4; y < kSize * 3 / 4; ++y) {
      for (int x = kSize / 4; x < kSize * 3 / 4; ++x, ++count) {
        const double green = picture.rgb[static_cast<std::size_t>(3 * (y * kSize + x) + 1)];
        sum += green;
        squares += green * green;
      }
    }
    const double mean = sum / count;
    return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
  }

  /// Levels drawn, and whether every tile has its relief.
  static std::vector<int> levels_with_relief(TerrainScene& scene, const LodCut& cut) {
    std::vector<int> levels;
    for (const DrawTile& d : cut.draws) {
      const codec::TileId& id = scene.bounds().nodes()[d.node].id;
      const GpuTile* tile = const_cast<GpuTilePool&>(scene.pool()).use({id, 0});
      EXPECT_TRUE(tile != nullptr && tile->relief.normals != 0) << id.text();
      EXPECT_EQ(tile != nullptr && tile->relief.heights != 0, id.level < kLeaf) << id.text();
      levels.push_back(id.level);
    }
    return levels;
  }

  test::TempDir dir_;
  int written_ = 0;
};

double bumps(double column, double row) { return 4 * std::sin(0.9 * column) * std::cos(0.7 * row); }

TEST_F(WaveletSceneTest, APatchsSamplesShowOnAMeshWithoutThem) {
  const auto flat = tree([](double, double) { return 0.0; });
  const auto bumpy = tree(bumps);
  // Down to the north-west, where the sun stands: brighter than level ground, evenly.
  const auto tilted = tree([](double column, double row) { return 3 * (column + row); });
  const Camera near = camera(150);
  const auto light_of = [&](const cache::TileStore& store) {
    const auto made = scene(store);
    const LodCut cut = settled(*made, near);
    EXPECT_EQ(std::ranges::max(levels_with_relief(*made, cut)), kLeaf);
    return light(*made, near, cut);
  };
  const auto [flat_mean, flat_spread] = light_of(flat);
  const auto [bumpy_mean, bumpy_spread] = light_of(bumpy);
  const auto [tilted_mean, tilted_spread] = light_of(tilted);
  EXPECT_LT(flat_spread, 2);
  EXPECT_GT(bumpy_spread, 5);
  EXPECT_GT(tilted_mean, flat_mean + 10);
  EXPECT_LT(tilted_spread, 2);
}

TEST_F(WaveletSceneTest, EveryTileHasItsReliefWhereverTheCameraJumps) {
  const auto store = tree(bumps);
  SceneOptions options;
  options.cache_bytes = 20000;
  const auto made = scene(store, options);
  for (const double distance_m : {150.0, 9000.0, 700.0, 60.0, 2000.0, 150.0}) {
    SCOPED_TRACE(distance_m);
    const LodCut cut = settled(*made, camera(distance_m));
    EXPECT_TRUE(cut.complete);
    levels_with_relief(*made, cut);
  }
}

TEST_F(WaveletSceneTest, ReliefsKeepWithinTheGraphicsMemory) {
  const auto store = tree(bumps);
  for (const std::size_t pictures : {std::size_t{1000}, std::size_t{6000}, std::size_t{20000}}) {
    SCOPED_TRACE(pictures);
    auto reconstructor = PatchReconstructor::create(gl_);
    ASSERT_TRUE(reconstructor);
    GpuTilePool pool(gl_, {.mesh_bytes = std::size_t{4} << 20, .picture_bytes = pictures},
                     {std::move(*reconstructor), nullptr});
    cache::TileCache cache(store, {});
    std::vector<cache::TileRef> all;
    for (const cache::TileNode& node : store.bounds().nodes()) all.push_back({node.id, 0});
    cache.request(all);
    cache.wait_idle();
    std::size_t lit = 0;
    for (const cache::TileRef& ref : all) {
      const auto tile = cache.get(ref);
      ASSERT_NE(tile, nullptr);
      ASSERT_TRUE(tile->relief.has_value());
      EXPECT_GT(tile->bytes(), tile->relief->residual.bytes());
      pool.end_frame();
      if (pool.upload(ref, *tile)) lit += pool.use(ref)->relief.normals != 0 ? 1 : 0;
      std::size_t held = 0;
      for (const cache::TileRef& other : all) {
        if (pool.contains(other)) held += pool.use(other)->relief.bytes;
      }
      EXPECT_LE(held, pictures);
    }
    // A root takes 4 bytes for each of 17 x 17 nodes and 20 x 20 heights.
    EXPECT_EQ(lit > 0, pictures >= 2756);
    EXPECT_EQ(lit > 1, pictures >= 2756 + 1156);
  }
}

}  // namespace
}  // namespace tintree::render
