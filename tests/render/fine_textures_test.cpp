#include "render/fine_textures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "render/terrain_scene.h"
#include "tests/render/analytic_tree.h"
#include "tests/render/osmesa_test.h"
#include "tests/support/picture_change.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

using codec::TileId;
using Rgb = std::array<std::uint8_t, 3>;

constexpr int kSize = 160;
constexpr int kDepth = 3;

/// Leaves of 32 cells with 16 texels, halved three times: then a texel is a quarter of a cell.
class FineTexturesTest : public OsMesaTest {
 protected:
  FineTexturesTest() {
    tree_.texture_depth = kDepth;
    set_levels(1);
  }

  void set_levels(int levels_per_doubling) {
    tree_.levels_per_doubling = levels_per_doubling;
    const codec::TreeLayout squares = tree_.squares();
    finest_ = squares.picture_tile({squares.leaf_level, 0, 0}).level;
  }
  /// Ground within two metres of 0, or at 0.
  void use_hills() {
    tree_.height_m = [](double x, double y) { return 2 * std::sin(x / 30) * std::cos(y / 40); };
  }
  void use_plain() {
    tree_.height_m = [](double, double) { return 0; };
  }

  /// Fields of one cell, red and green in turn, in the finest textures; leaves are blue, what is between them grey.
  void use_chessboard() {
    tree_.photo = [this](const TileId& id, double column, double row) -> Rgb {
      if (id.level <= tree_.layout().leaf_level) return {0, 0, 255};
      if (id.level < finest_) return {128, 128, 128};
      return static_cast<int>(std::floor(column) + std::floor(row)) % 2 == 0 ? Rgb{255, 0, 0} : Rgb{0, 255, 0};
    };
  }

  void open(const SceneOptions& options = {}) {
    scene_.reset();
    store_.emplace(std::move(*cache::TileStore::open(path_)));
    scene_ = std::move(*TerrainScene::create(gl_, *store_, options));
  }

  static Camera camera(const glm::dvec3& eye, const glm::dvec3& target) {
    Camera c;
    c.eye = eye;
    c.target = target;
    c.width_px = c.height_px = kSize;
    return c;
  }
  /// Straight down, on a point where four leaves meet unless `off` takes it away.
  static Camera above(double height_m, double off_m = 0) {
    const glm::dvec3 at(640 + off_m, -640 - off_m, 0);
    return camera(at + glm::dvec3(0, 0, height_m), at + glm::dvec3(0, 0.001, 0));
  }

  Picture picture(const Camera& c) {
    const auto cut = scene_->settle(c);
    EXPECT_TRUE(cut);
    cut_ = *cut;
    const auto target = OffscreenTarget::create(gl_, kSize, kSize, 1);
    Style style;
    style.background = glm::vec3(1, 0, 1);
    scene_->draw(*target, c, *cut, style);
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    return target->read_picture();
  }

  enum class Field { kRed, kGreen, kOther };
  static Field field_of(const Rgb& c) {
    if (c[0] > 2 * c[1] && c[0] > 2 * c[2]) return Field::kRed;
    return c[1] > 2 * c[0] && c[1] > 2 * c[2] ? Field::kGreen : Field::kOther;
  }

  /// The cell of the grid that a pixel shows, wherever between -2 and 2 metres the ground lies, if it does not lie near
  /// its sides, where texels of two fields are mixed.
  static std::optional<std::array<int, 2>> cell_at(const Camera& c, int x, int y) {
    std::set<std::array<int, 2>> cells;
    const glm::dvec3 ray = c.ray(x + 0.5, y + 0.5);
    for (const double z : {-2.0, 0.0, 2.0}) {
      const glm::dvec3 at = c.eye + ray * ((z - c.eye.z) / ray.z);
      const double u = at.x / 10;
      const double v = -at.y / 10;
      if (u - std::floor(u) < 0.05 || u - std::floor(u) > 0.7) return std::nullopt;
      if (v - std::floor(v) < 0.05 || v - std::floor(v) > 0.7) return std::nullopt;
      cells.insert({static_cast<int>(std::floor(u)), static_cast<int>(std::floor(v))});
    }
    return cells.size() == 1 ? std::optional(*cells.begin()) : std::nullopt;
  }

  static Field expected_at(const std::array<int, 2>& cell) {
    return (cell[0] + cell[1]) % 2 == 0 ? Field::kRed : Field::kGreen;
  }

  static int largest_difference(const Picture& a, const Picture& b) {
    int out = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) out = std::max(out, std::abs(int{a.rgb[i]} - int{b.rgb[i]}));
    return out;
  }

  test::TempDir dir_;
  const std::string path_ = dir_.file("tree.tintree");
  test::AnalyticTree tree_;
  int finest_ = 0;
  std::optional<cache::TileStore> store_;
  std::unique_ptr<TerrainScene> scene_;
  LodCut cut_;
};

TEST_F(FineTexturesTest, FieldsLieWhereTheyShould) {
  for (const int levels : {1, 2}) {
    set_levels(levels);
    use_chessboard();
    use_hills();
    tree_.write(path_);
    open();
    for (const double off_m : {0.0, 133.0}) {
      const Camera c = above(150, off_m);
      const Picture p = picture(c);
      EXPECT_TRUE(cut_.complete);
      int judged = 0;
      for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
          const auto cell = cell_at(c, x, y);
          if (!cell) continue;
          ++judged;
          ASSERT_EQ(field_of(p.at(x, y)), expected_at(*cell)) << x << ' ' << y << " of leaf " << (*cell)[0];
        }
      }
      EXPECT_GT(judged, 500);
    }
    scene_.reset();
    store_.reset();
    std::filesystem::remove(path_);
  }
}

// The picture is that of textures so large that a leaf needs no more: no seam, no texel out of place.
TEST_F(FineTexturesTest, LikeOneLargeTexture) {
  tree_.photo = [](const TileId&, double column, double row) -> Rgb {
    const auto wave = [](double v) { return static_cast<std::uint8_t>(std::lround(128 + 90 * std::sin(v))); };
    return {wave(column / 1.7), wave(row / 1.3), wave((column + row) / 2.9)};
  };
  const auto open_finest = [this] {
    open();
    // The finest everywhere: with larger textures a view would do with coarser tiles.
    scene_->cut_options().pixel_error = 0;
    scene_->cut_options().texel_px = 0;
  };
  tree_.write(path_);
  open_finest();
  const std::array views{above(300), above(220, 41), camera({560, -800, 140}, {640, -640, 30}),
                         camera({720, -520, 120}, {640, -680, 0})};
  std::vector<Picture> fine;
  for (const Camera& c : views) {
    fine.push_back(picture(c));
    EXPECT_TRUE(cut_.complete && !cut_.parts.empty());
  }
  test::AnalyticTree large = tree_;
  large.texture_size = 16 << kDepth;
  large.texture_depth = 0;
  scene_.reset();
  store_.reset();
  std::filesystem::remove(path_);
  large.write(path_);
  open_finest();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Picture whole = picture(views[i]);
    EXPECT_LE(largest_difference(fine[i], whole), 24) << i;
    double sum = 0;
    for (std::size_t k = 0; k < whole.rgb.size(); ++k) sum += std::abs(int{fine[i].rgb[k]} - int{whole.rgb[k]});
    EXPECT_LT(sum / static_cast<double>(whole.rgb.size()), 1) << i;
  }
}

// A view near the ground holds a few of all of them; where there is no room for those, it shows coarser ones.
TEST_F(FineTexturesTest, StaysWithinTheMemory) {
  tree_.columns = tree_.rows = 33;
  tree_.tile_cells = 8;
  tree_.texture_size = 128;
  use_plain();
  tree_.color = [this](const TileId& id) -> Rgb {
    const int leaf_level = tree_.layout().leaf_level;
    return id.level <= leaf_level ? Rgb{0, 0, 255} : id.level == leaf_level + 1 ? Rgb{128, 128, 128} : Rgb{0, 255, 0};
  };
  tree_.write(path_);
  const Camera c = above(40, -560);
  const auto green = [this, &c] {
    const Picture p = picture(c);
    int out = 0;
    for (int i = 0; i < kSize * kSize; ++i) {
      EXPECT_NE(p.at(i % kSize, i / kSize), (Rgb{255, 0, 255}));
      out += field_of(p.at(i % kSize, i / kSize)) == Field::kGreen ? 1 : 0;
    }
    return out;
  };
  SceneOptions options;
  for (const std::size_t bytes : {std::size_t{8} << 20, std::size_t{250} << 10}) {
    const bool roomy = bytes > std::size_t{1} << 20;
    options.gpu_bytes = bytes;
    open(options);
    for (int round = 0; round < 2; ++round) {
      const int seen = green();
      EXPECT_EQ(seen == kSize * kSize, roomy) << seen;
      EXPECT_GT(seen, 0);
      EXPECT_EQ(scene_->frame_stats().gpu_memory_full, !roomy);
      const FineTextures& fine = scene_->pool().fine_textures();
      EXPECT_LE(fine.bytes(), fine.reserved_bytes());
      EXPECT_LE(fine.reserved_bytes(), bytes / 4);
      EXPECT_LE(scene_->pool().reserved_bytes(), bytes);
      // Of 16 leaves, each halved to 4, 16 and 64 squares.
      EXPECT_GT(fine.textures(), 4U);
      EXPECT_LT(fine.textures(), 60U);
      // Elsewhere others take their place.
      for (int step = 0; step < 8; ++step) picture(above(40, -600.0 + 10 * step));
    }
  }
}

TEST_F(FineTexturesTest, ADamagedOneIsStoodInForAndSaidOnce) {
  use_chessboard();
  use_plain();
  tree_.write(path_);
  // North-west of the point that the camera looks at.
  const TileId square{finest_, 15, 15};
  const std::vector<std::byte> noise(7);
  test::replace_picture(path_, cache::PictureKind::kTexture, square, noise);
  open();
  const Camera c = above(150);
  for (int round = 0; round < 2; ++round) {
    const Picture p = picture(c);
    int judged = 0;
    int coarser = 0;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const auto cell = cell_at(c, x, y);
        if (!cell) continue;
        ++judged;
        // Squares are four cells a side.
        const bool damaged = (*cell)[0] / 4 == 15 && (*cell)[1] / 4 == 15;
        coarser += damaged ? 1 : 0;
        ASSERT_EQ(field_of(p.at(x, y)), damaged ? Field::kOther : expected_at(*cell)) << x << ' ' << y;
      }
    }
    EXPECT_GT(judged, 1000);
    EXPECT_GT(coarser, 50);
    const auto errors = scene_->take_errors();
    ASSERT_EQ(errors.size(), round == 0 ? 1U : 0U);
    if (round > 0) continue;
    EXPECT_NE(errors[0].text().find(square.text()), std::string::npos) << errors[0].text();
    EXPECT_NE(errors[0].text().find(path_), std::string::npos) << errors[0].text();
  }
}

// Where no photo is finer, the leaf's own texture stays, and nothing more is waited for.
TEST_F(FineTexturesTest, LeavesWithoutKeepTheirOwn) {
  use_chessboard();
  tree_.has_texture = [this](const TileId& id) {
    TileId leaf = id;
    while (leaf.level > tree_.layout().leaf_level) leaf = tree_.squares().parent(leaf);
    return leaf == TileId{2, 1, 1};
  };
  use_plain();
  tree_.write(path_);
  open();
  const Camera c = above(150);
  const Picture p = picture(c);
  EXPECT_TRUE(cut_.complete);
  EXPECT_TRUE(scene_->take_errors().empty());
  int fields = 0;
  int blue = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const auto cell = cell_at(c, x, y);
      if (!cell) continue;
      const Rgb color = p.at(x, y);
      const bool has = (*cell)[0] < 64 && (*cell)[1] < 64;
      ++(has ? fields : blue);
      if (has) {
        ASSERT_EQ(field_of(color), expected_at(*cell));
      } else {
        ASSERT_GT(color[2], 2 * std::max(color[0], color[1]));
      }
    }
  }
  EXPECT_GT(fields, 300);
  EXPECT_GT(blue, 300);
}

// A card without S3TC gets plain texels, of leaves and of what is finer: the same picture but for rounding.
TEST_F(FineTexturesTest, LooksTheSameWithoutCompressedTextures) {
  tree_.photo = [](const TileId& id, double column, double row) -> Rgb {
    const auto wave = [](double v) { return static_cast<std::uint8_t>(std::lround(128 + 90 * std::sin(v))); };
    return {wave(column / 7), wave(row / 5), static_cast<std::uint8_t>(20 * id.level)};
  };
  use_hills();
  tree_.write(path_);
  const std::array views{above(150), above(5000)};
  std::vector<Picture> packed;
  ASSERT_TRUE(gl_.texture_blocks);
  for (const bool blocks : {true, false}) {
    gl_.texture_blocks = blocks;
    open();
    gl_.texture_blocks = true;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const Picture p = picture(views[i]);
      EXPECT_TRUE(cut_.complete);
      EXPECT_EQ(cut_.parts.empty(), i > 0);
      const auto tile = scene_->cache().peek({scene_->bounds().nodes()[cut_.draws.front().node].id, 0});
      ASSERT_NE(tile, nullptr);
      EXPECT_EQ(tile->pictures.colors.format, blocks ? codec::PixelFormat::kBc1 : codec::PixelFormat::kRgba8);
      if (blocks) {
        packed.push_back(p);
      } else {
        EXPECT_LE(largest_difference(p, packed[i]), 3) << i;
      }
    }
  }
}

// Flying straight on, the cache has what the view will want a second later, as a scene that is there tells; and what
// the present view shows stays, in as much memory as was given.
TEST_F(FineTexturesTest, AreLoadedAhead) {
  tree_.columns = tree_.rows = 257;
  use_chessboard();
  use_plain();
  tree_.write(path_);
  const auto at = [](double seconds) {
    const glm::dvec3 eye(300 + 700 * seconds, -1280, 60);
    return camera(eye, eye + glm::dvec3(50, 0, -40));
  };
  constexpr double kNow = 0.5;
  open();
  std::vector<cache::TileRef> wanted;
  for (const auto& part : [&] {
         picture(at(kNow + 1));
         return cut_.parts;
       }())
    wanted.push_back({part.texture, 0});
  ASSERT_GT(wanted.size(), 20U);
  picture(at(kNow));
  std::set<std::uint64_t> here;
  for (const TexturePart& p : cut_.parts) here.insert(p.texture.key());
  const std::size_t all_bytes = scene_->frame_stats().cache_bytes;
  std::erase_if(wanted, [&](const cache::TileRef& t) { return here.contains(t.id.key()); });
  ASSERT_GT(wanted.size(), 20U) << "nothing to load ahead";
  for (const bool roomy : {true, false}) {
    SceneOptions options;
    if (!roomy) options.cache_bytes = all_bytes / 4;
    open(options);
    ASSERT_TRUE(scene_->settle(at(kNow)));
    for (int i = 0; i <= 10; ++i) scene_->update(at(kNow * i / 10), kNow * i / 10);
    ASSERT_TRUE(scene_->settle(at(kNow)));
    const auto lacks = [this, &wanted] {
      return std::ranges::count_if(wanted,
                                   [this](const cache::TileRef& t) { return scene_->cache().peek(t) == nullptr; });
    };
    for (int i = 0; i < (roomy ? 5000 : 100) && lacks() > 0; ++i) {
      const LodCut cut = scene_->update(at(kNow), kNow);
      EXPECT_TRUE(cut.complete);
      usleep(1000);
    }
    EXPECT_EQ(lacks() == 0, roomy) << lacks() << " of " << wanted.size();
    EXPECT_TRUE(scene_->update(at(kNow)).complete);
    EXPECT_LE(scene_->cache().stats().bytes, options.cache_bytes);
  }
}

}  // namespace
}  // namespace tintree::render
