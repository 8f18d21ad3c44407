// Trees of method wavelet, drawn under OSMesa: lit by what their patches have beyond their meshes.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <gtest/gtest.h>

#include "codec/wavelet_tiles.h"
#include "render/ground_style.h"
#include "render/terrain_scene.h"
#include "tests/render/osmesa_test.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

constexpr int kCells = 16;
constexpr int kLeaf = 2;
constexpr int kSize = 200;
constexpr double kSpacingM = 10;

/// A flat mesh at every level, and patches of any heights in metres over columns and rows.
class FlatTree {
 public:
  explicit FlatTree(std::function<double(double, double)> height_m) : height_m_(std::move(height_m)) {
    layout_.columns = layout_.rows = (kCells << kLeaf) + 1;
    layout_.tile_cells = kCells;
    layout_.leaf_level = kLeaf;
    layout_.dx_m = layout_.dy_m = kSpacingM;
    layout_.leaf_error_m = 1;
    layout_.z_step_m = {0.5, 0.25, 0.125};
  }

  void write(const std::string& path, const std::string& criterion) const {
    cache::Manifest manifest;
    manifest.method = "wavelet";
    manifest.criterion = criterion;
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
  cache::TileStore tree(const std::function<double(double, double)>& height_m, const std::string& criterion = "max") {
    const std::string path = dir_.file("tree" + std::to_string(written_++) + ".tintree");
    FlatTree(height_m).write(path, criterion);
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

  /// How bright the picture's middle is: the green of its pixels, row by row.
  static std::vector<double> light(TerrainScene& scene, const Camera& camera, const LodCut& cut) {
    const auto target = OffscreenTarget::create(gl_, kSize, kSize, 1);
    EXPECT_TRUE(target);
    scene.draw(*target, camera, cut, {});
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    const Picture picture = target->read_picture();
    std::vector<double> out;
    for (int y = kSize / 4; y < kSize * 3 / 4; ++y)
      for (int x = kSize / 4; x < kSize * 3 / 4; ++x) out.push_back(picture.at(x, y)[1]);
    return out;
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

using HeightOf = std::function<double(double column, double row)>;

/// The normal between the four nodes around a place, of central differences of the heights at the nodes.
glm::dvec3 normal_at(const HeightOf& height_m, double column, double row) {
  glm::dvec2 east_north{0, 0};
  for (const int dx : {0, 1}) {
    for (const int dy : {0, 1}) {
      const double c = std::floor(column) + dx;
      const double r = std::floor(row) + dy;
      const glm::dvec3 n = glm::normalize(
          glm::dvec3(height_m(c - 1, r) - height_m(c + 1, r), height_m(c, r + 1) - height_m(c, r - 1), 2 * kSpacingM));
      east_north += glm::dvec2(n) * (1 - std::abs(column - c)) * (1 - std::abs(row - r));
    }
  }
  return {east_north, std::sqrt(1 - glm::dot(east_north, east_north))};
}

/// Green light of the sun and the sky on a surface with that normal.
double green_light(const glm::dvec3& normal) {
  const Style style;
  const double level = std::cos(style.sun_elevation_rad);
  const glm::dvec3 to_sun(std::sin(style.sun_azimuth_rad) * level, std::cos(style.sun_azimuth_rad) * level,
                          std::sin(style.sun_elevation_rad));
  return 1.36 * std::max(glm::dot(normal, to_sun), 0.0) + std::lerp(0.07, 0.21, 0.5 + 0.5 * normal.z);
}

/// What becomes of a picture of level ground when the ground is lit as one of these heights, computed pixel by pixel.
std::vector<double> relit(std::vector<double> flat, const HeightOf& height_m, const Camera& camera) {
  auto at = flat.begin();
  for (int y = kSize / 4; y < kSize * 3 / 4; ++y) {
    for (int x = kSize / 4; x < kSize * 3 / 4; ++x, ++at) {
      const glm::dvec3 ray = camera.ray(x + 0.5, y + 0.5);
      const glm::dvec3 ground = camera.eye - ray * (camera.eye.z / ray.z);
      const glm::dvec3 n = normal_at(height_m, ground.x / kSpacingM, -ground.y / kSpacingM);
      *at = std::min(255.0, *at * std::pow(green_light(n) / green_light({0, 0, 1}), 1 / 2.2));
    }
  }
  return flat;
}

double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

TEST_F(WaveletSceneTest, APatchsSamplesShowOnAMeshWithoutThem) {
  const Camera near = camera(150);
  const auto light_of = [&](const HeightOf& height_m) {
    const auto store = tree(height_m);
    const auto made = scene(store);
    const LodCut cut = settled(*made, near);
    EXPECT_EQ(std::ranges::max(levels_with_relief(*made, cut)), kLeaf);
    return light(*made, near, cut);
  };
  const std::vector<double> flat = light_of([](double, double) { return 0.0; });
  const double mean = std::accumulate(flat.begin(), flat.end(), 0.0) / static_cast<double>(flat.size());
  EXPECT_LT(rms_difference(flat, std::vector<double>(flat.size(), mean)), 2) << "level ground is lit evenly";
  // Down to the north-west, where the sun stands, and waves of nine and seven samples.
  const std::vector<HeightOf> grounds{[](double column, double row) { return 3 * (column + row); }, bumps};
  for (const HeightOf& height_m : grounds) {
    const std::vector<double> expected = relit(flat, height_m, near);
    const double most = 2;  // grey levels
    EXPECT_LT(rms_difference(light_of(height_m), expected), most);
    EXPECT_GT(rms_difference(flat, expected), 3 * most) << "there was to be something to see";
  }
}

/// Their patches are farther from the truth than their vertices (docs/methods.md).
TEST_F(WaveletSceneTest, TreesOfCriterionRmsAreLitByTheirVertices) {
  const Camera near = camera(150);
  const auto light_of = [&](const HeightOf& height_m, const std::string& criterion) {
    const auto store = tree(height_m, criterion);
    const auto made = scene(store);
    return light(*made, near, settled(*made, near));
  };
  const auto level = [](double, double) { return 0.0; };
  EXPECT_EQ(light_of(bumps, "rms"), light_of(level, "rms")) << "meshes are flat, whatever patches have";
  EXPECT_NE(light_of(bumps, "max"), light_of(level, "max"));
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
                     {std::move(*reconstructor), nullptr, nullptr});
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
