#include "simplify/picture_pyramid.h"

#include <cmath>
#include <map>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "codec/normal_codec.h"
#include "codec/texture_codec.h"
#include "simplify/srgb.h"
#include "tests/support/regular_tree.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_photo.h"

namespace tintree::simplify {
namespace {

using cache::PictureKind;
using codec::TileId;

const ProgressFn kGoOn = [](const std::string&, std::uint64_t, std::uint64_t) { return true; };

/// A tree of 16-cell tiles over 70 x 50 samples, with a photo on the same grid.
class PicturePyramidTest : public testing::Test {
 protected:
  PicturePyramidTest() {
    const test::RasterSpec spec{.columns = 71, .rows = 51, .dx = 10, .dy = 8};
    test::write_raster(dem_, spec, [](int c, int r) { return height(c, r); });
    test::write_photo(photo_, spec, true, [](int c, int r) { return color(c, r); });
    source_ = std::make_shared<cache::RasterSource>(std::move(*cache::RasterSource::open(dem_)));
    tree_ = test::make_regular_tree(*source_);
    tree_.manifest.texture_size = 16;
    tree_.manifest.texture_codec = "bc1";
    tree_.manifest.normal_maps = true;
    tree_.manifest.complete = false;
    photos_.emplace(std::move(*cache::OrthoSource::open({photo_}, source_->info())));
    surface_ = std::move(*ReferenceSurface::scan(std::make_shared<cache::HeightBlocks>(source_, 1 << 22),
                                                 [](std::uint64_t, std::uint64_t) { return true; }));
  }

  static double height(int c, int r) { return test::hills(c, r, 60); }
  /// Colours on a line, which BC1 keeps well.
  static std::array<std::uint8_t, 4> color(int c, int r) {
    const auto both = test::meadow(c, r);
    const auto v = static_cast<std::uint8_t>((both[0] + both[1]) / 2);
    return {v, static_cast<std::uint8_t>(v / 2 + 60), static_cast<std::uint8_t>(200 - v / 2),
            static_cast<std::uint8_t>(c > 55 ? 0 : 255)};
  }

  cache::TileWriter writer(const std::string& name) const {
    auto out = cache::TileWriter::create(dir_.file(name), tree_.manifest);
    for (const cache::StoredTile& tile : tree_.tiles) EXPECT_TRUE(out->put(tile).has_value());
    return std::move(*out);
  }
  MakeLayer textures() const {
    return [this] { return make_texture_layer(tree_.manifest, *photos_); };
  }
  MakeLayer normals() const {
    return [this] { return make_normal_layer(tree_.manifest, *surface_, nullptr); };
  }
  codec::ColorImage texture(const cache::TileWriter& writer, const TileId& id) const {
    const auto payload = writer.read_picture(PictureKind::kTexture, id);
    return *codec::find_texture_codec("bc1")->decode(**payload, 17);
  }

  test::TempDir dir_;
  std::string dem_ = dir_.file("dem.tif");
  std::string photo_ = dir_.file("photo.tif");
  std::shared_ptr<cache::RasterSource> source_;
  test::TestTree tree_;
  std::optional<cache::OrthoSource> photos_;
  std::unique_ptr<ReferenceSurface> surface_;
};

TEST_F(PicturePyramidTest, LeavesAreThePhotoAndAgreeOnTheirSides) {
  const auto layer = make_texture_layer(tree_.manifest, *photos_);
  const int leaf = tree_.manifest.layout.leaf_level;
  std::map<std::pair<int, int>, std::array<float, 4>> nodes;
  for (std::uint32_t y = 0; y < 3; ++y) {
    for (std::uint32_t x = 0; x < 4; ++x) {
      const auto values = layer->make_leaf({leaf, x, y});
      ASSERT_TRUE(values.has_value());
      for (int v = 0; v <= 16; ++v) {
        for (int u = 0; u <= 16; ++u) {
          const int c = static_cast<int>(16 * x) + u;
          const int r = static_cast<int>(16 * y) + v;
          const auto& value = values->at(u, v);
          const auto [at, added] = nodes.try_emplace({c, r}, value);
          ASSERT_EQ(at->second, value) << "neighbours differ";
          const bool covered = c <= 55 && r <= 50;
          ASSERT_EQ(value[3] > 0, covered) << c << " " << r;
          for (std::size_t k = 0; covered && k < 3; ++k)
            ASSERT_NEAR(srgb_of(value[k]), color(c, r)[k], 1) << c << " " << r;
        }
      }
    }
  }
}

/// The root against the photo filtered as a whole, which no tile border can disturb.
TEST_F(PicturePyramidTest, CoarserLevelsAreThePhotoFilteredAsAWhole) {
  auto file = writer("a");
  const auto made = make_pictures(PictureKind::kTexture, textures(), tree_.manifest, file, kGoOn);
  ASSERT_TRUE(made.has_value()) << made.error().text();
  const int levels = tree_.manifest.layout.leaf_level;
  // From node -64 on, so that every filter has room.
  const int margin = 64;
  const int side = (16 << levels) + 1 + 2 * margin;
  NodeValues whole(side, side);
  for (int v = 0; v < side; ++v) {
    for (int u = 0; u < side; ++u) {
      const int c = u - margin;
      const int r = v - margin;
      // Beyond the tree there is nothing, beyond the photo nothing covered.
      if (c < 0 || r < 0 || c > 55 || r > 50) continue;
      const auto p = color(c, r);
      whole.at(u, v) = {linear_of(p[0]), linear_of(p[1]), linear_of(p[2]), 1};
    }
  }
  int origin = margin;
  for (int level = levels; level >= 0; --level) {
    double squares = 0;
    double count = 0;
    for (const cache::StoredTile& tile : tree_.tiles) {
      const TileId id = tile.info.id;
      if (id.level != level || !*file.read_picture(PictureKind::kTexture, id)) continue;
      const codec::ColorImage image = texture(file, id);
      for (int v = 0; v <= 16; ++v) {
        for (int u = 0; u <= 16; ++u) {
          const auto& expected =
              whole.at(origin + static_cast<int>(16 * id.x) + u, origin + static_cast<int>(16 * id.y) + v);
          if (std::abs(expected[3] - 0.5F) < 0.1F || expected[3] < 0.5F || image.at(u, v)[3] == 0) continue;
          for (std::size_t k = 0; k < 3; ++k) squares += std::pow(srgb_of(expected[k]) - image.at(u, v)[k], 2);
          count += 3;
        }
      }
    }
    ASSERT_GT(count, 100) << level;
    EXPECT_LT(std::sqrt(squares / count), 9) << level;
    // A node of the coarser grid lies at each second one of the finer; keep the first node of the tree among them.
    const int reach = kSharpHalving.reach;
    NodeValues shifted(whole.width - (origin + reach) % 2, whole.height - (origin + reach) % 2);
    const int skip = (origin + reach) % 2;
    for (int v = 0; v < shifted.height; ++v) {
      for (int u = 0; u < shifted.width; ++u) shifted.at(u, v) = whole.at(u + skip, v + skip);
    }
    whole = halve(shifted, kSharpHalving);
    for (auto& value : whole.values) value[3] = value[3] < 0.5F ? 0.0F : 1.0F;
    origin = (origin - skip - reach) / 2;
  }
}

TEST_F(PicturePyramidTest, TilesWithoutAPhotoHaveNoTexture) {
  auto file = writer("a");
  const auto made = make_pictures(PictureKind::kTexture, textures(), tree_.manifest, file, kGoOn);
  ASSERT_TRUE(made.has_value());
  const int leaf = tree_.manifest.layout.leaf_level;
  EXPECT_FALSE(file.read_picture(PictureKind::kTexture, {leaf, 4, 0})->has_value());
  EXPECT_TRUE(file.read_picture(PictureKind::kTexture, {leaf, 3, 0})->has_value());
  EXPECT_LT(made->pictures, tree_.tiles.size());
  EXPECT_EQ(made->made, made->pictures);
}

/// Any number of threads, and a stop in between, give the same file.
TEST_F(PicturePyramidTest, IsTheSameAfterAStopAndAtAnyNumberOfThreads) {
  const auto make_all = [&](cache::TileWriter& file, int threads, int stop_after) {
    tbb::task_arena arena(threads);
    int calls = 0;
    const ProgressFn progress = [&](const std::string&, std::uint64_t, std::uint64_t) { return ++calls != stop_after; };
    std::uint64_t made = 0;
    arena.execute([&] {
      for (const auto& [kind, layer] :
           {std::pair{PictureKind::kTexture, textures()}, std::pair{PictureKind::kNormal, normals()}}) {
        const auto done = make_pictures(kind, layer, tree_.manifest, file, progress);
        if (done) made += done->made;
      }
    });
    return made;
  };
  auto one = writer("one");
  const std::uint64_t all = make_all(one, 1, -1);
  auto other = writer("other");
  make_all(other, 4, 5);
  EXPECT_LT(make_all(other, 3, -1), all) << "what was there was made again";
  EXPECT_EQ(*one.finish(), *other.finish());
}

/// Normals against the gradient of the heights, differenced by hand.
TEST_F(PicturePyramidTest, NormalsAreThoseOfTheHeights) {
  const auto layer = make_normal_layer(tree_.manifest, *surface_, nullptr);
  const auto values = layer->make_leaf({tree_.manifest.layout.leaf_level, 1, 1});
  ASSERT_TRUE(values.has_value());
  for (int v = 0; v <= 16; ++v) {
    for (int u = 0; u <= 16; ++u) {
      const int c = 16 + u;
      const int r = 16 + v;
      const double east = (height(c + 1, r) - height(c - 1, r)) / 20;
      const double north = (height(c, r - 1) - height(c, r + 1)) / 16;
      const double length = std::sqrt(1 + east * east + north * north);
      ASSERT_NEAR(values->at(u, v)[0], -east / length, 1e-4);
      ASSERT_NEAR(values->at(u, v)[1], -north / length, 1e-4);
      ASSERT_NEAR(values->at(u, v)[2], 1 / length, 1e-4);
    }
  }
}

/// A coarse mean normal is the mean of what lies under its tent, and the shorter the more that turns.
TEST_F(PicturePyramidTest, CoarseNormalsAreMeans) {
  auto file = writer("a");
  ASSERT_TRUE(make_pictures(PictureKind::kNormal, normals(), tree_.manifest, file, kGoOn).has_value());
  const int leaf = tree_.manifest.layout.leaf_level;
  const auto decoded = [&](const TileId& id) {
    return *codec::decode_normals(**file.read_picture(PictureKind::kNormal, id), 17);
  };
  const auto parent = decoded({leaf - 1, 0, 0});
  const auto child = decoded({leaf, 0, 0});
  float shortest = 1;
  for (int v = 1; v < 8; ++v) {
    for (int u = 1; u < 8; ++u) {
      std::array<double, 3> mean{};
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const double w = (2 - std::abs(dx)) * (2 - std::abs(dy)) / 16.0;
          for (std::size_t k = 0; k < 3; ++k) mean[k] += w * child.at(2 * u + dx, 2 * v + dy)[k];
        }
      }
      const auto& n = parent.at(u, v);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(n[k], mean[k], 0.08);
      shortest = std::min(shortest, std::hypot(n[0], n[1], n[2]));
    }
  }
  EXPECT_LT(shortest, 0.99F);
}

}  // namespace
}  // namespace tintree::simplify
