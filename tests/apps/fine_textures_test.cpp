/// Photos finer than the leaves' textures: on squares that the leaves are halved to.

#include <cmath>
#include <map>

#include "codec/texture_codec.h"
#include "tests/apps/build_support.h"
#include "tests/support/test_photo.h"

namespace tintree::test {
namespace {

using cache::PictureKind;
using codec::ColorImage;
using codec::TileId;
using nlohmann::json;

using Images = std::map<std::int64_t, ColorImage>;

class FineTexturesTest : public BuildTest {
 protected:
  FineTexturesTest() : photo_(dir_.file("photo.tif")), part_(dir_.file("part.tif")) {
    // Four pixels a sample each way: textures of 32 texels want leaves halved twice.
    write_photo(photo_, {.columns = 360, .rows = 280, .dx = 2.5, .dy = 2.5}, false, meadow);
  }

  /// All textures of a build.
  Images build_images(const Words& more) {
    fs::remove(tree_);
    EXPECT_NE(digest(more), "");
    const auto store = cache::TileStore::open(tree_);
    manifest_ = store->manifest();
    EXPECT_EQ(*store->digest(), manifest_.digest);
    Images out;
    const auto keys = store->picture_keys(PictureKind::kTexture);
    for (const std::int64_t key : *keys) {
      const auto payload = store->read_picture(PictureKind::kTexture, TileId::from_key(key));
      out.emplace(key, *codec::find_texture_codec(manifest_.texture_codec)
                            ->decode(**payload, manifest_.picture_size(PictureKind::kTexture)));
    }
    return out;
  }

  /// The square that a photo of 2.5 m pixels with a part of the columns and rows of photo_ covers.
  static RasterSpec part_spec(int column, int row, int columns, int rows) {
    return {
        .columns = columns, .rows = rows, .dx = 2.5, .dy = 2.5, .west = 1000 + 2.5 * column, .north = 2000 - 2.5 * row};
  }

  std::string photo_;
  std::string part_;
  cache::Manifest manifest_;
};

// The same texels as in textures so large that a leaf needs no more: a coded block holds four by four of them, none of
// which lies in two squares but those on their sides.
TEST_F(FineTexturesTest, AreAsFineAsThePhoto) {
  const Images large = build_images({"--ortho", photo_, "--texture-size", "128"});
  EXPECT_EQ(manifest_.texture_depth, 0);
  for (const char* levels : {"1", "2"}) {
    const Images small = build_images({"--ortho", photo_, "--texture-size", "32", "--levels-per-doubling", levels});
    ASSERT_EQ(manifest_.texture_depth, 2);
    const codec::TreeLayout squares = manifest_.picture_layout(PictureKind::kTexture);
    int compared = 0;
    for (const auto& [key, fine] : small) {
      const TileId id = TileId::from_key(key);
      EXPECT_EQ(id, squares.picture_tile(id));
      if (!squares.is_leaf_square(id.level)) continue;
      ++compared;
      const ColorImage& leaf = large.at(TileId{2, id.x / 4, id.y / 4}.key());
      for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 32; ++x) {
          const int u = static_cast<int>(id.x % 4) * 32 + x;
          const int v = static_cast<int>(id.y % 4) * 32 + y;
          for (std::size_t k = 0; k < 4; ++k) ASSERT_EQ(fine.at(x, y)[k], leaf.at(u, v)[k]) << id.text();
        }
      }
    }
    EXPECT_GT(compared, 90);
  }
}

// A node lies at the sample's middle, between two pixels of the photo each way. What GDAL makes of it is left out.
TEST_F(FineTexturesTest, LieWhereThePhotoDoes) {
  const Images images = build_images({"--ortho", photo_, "--texture-size", "32", "--texture-codec", "jpeg"});
  const codec::TreeLayout squares = manifest_.picture_layout(PictureKind::kTexture);
  double squares_sum = 0;
  int texels = 0;
  for (const auto& [key, image] : images) {
    const TileId id = TileId::from_key(key);
    if (!squares.is_leaf_square(id.level)) continue;
    for (int y = 0; y <= 32; ++y) {
      for (int x = 0; x <= 32; ++x) {
        // Side by side lie 2 and 1 for node 0, 3 and 2 for node 1.
        const int column = static_cast<int>(id.x) * 32 + x + 1;
        const int row = static_cast<int>(id.y) * 32 + y + 1;
        if (column >= 359 || row >= 279) continue;
        for (std::size_t k = 0; k < 3; ++k) {
          const double mean = (meadow(column, row)[k] + meadow(column + 1, row)[k] + meadow(column, row + 1)[k] +
                               meadow(column + 1, row + 1)[k]) /
                              4.0;
          squares_sum += std::pow(image.at(x, y)[k] - mean, 2);
          ++texels;
        }
      }
    }
  }
  EXPECT_GT(texels, 250000);
  EXPECT_LT(std::sqrt(squares_sum / texels), 4);
}

TEST_F(FineTexturesTest, GoNoDeeperThanAsked) {
  EXPECT_FALSE(build_images({"--ortho", photo_, "--texture-size", "32", "--texture-depth", "1"}).empty());
  EXPECT_EQ(manifest_.texture_depth, 1);
  // By itself a texture grows before leaves are halved.
  EXPECT_FALSE(build_images({"--ortho", photo_}).empty());
  EXPECT_EQ(manifest_.texture_depth, 0);
  fs::remove(tree_);
  expect_refused({"--ortho", photo_, "--texture-depth", "6"}, kUsage, {"--texture-depth", "0 to 5"});
}

// Below the leaves, only what finer photos reach is stored, and it shows them; a leaf beyond is as it is without them.
TEST_F(FineTexturesTest, OnlyWhereAPhotoIsFiner) {
  write_photo(photo_, {.columns = 90, .rows = 70, .dx = 10, .dy = 10}, false, [](int, int) {
    return std::array<std::uint8_t, 4>{200, 40, 40, 255};
  });
  const Images coarse = build_images({"--ortho", photo_, "--texture-size", "32"});
  EXPECT_EQ(manifest_.texture_depth, 0);
  // Columns and rows 35 to 45 of the DEM, with a hole in the middle of it.
  write_photo(part_, part_spec(140, 140, 40, 40), true, [](int c, int r) {
    const bool hole = c > 12 && c < 28 && r > 12 && r < 28;
    return std::array<std::uint8_t, 4>{40, 40, 200, static_cast<std::uint8_t>(hole ? 0 : 255)};
  });
  const Images both = build_images({"--ortho", photo_, part_, "--texture-size", "32"});
  ASSERT_EQ(manifest_.texture_depth, 2);
  const codec::TreeLayout squares = manifest_.picture_layout(PictureKind::kTexture);
  int fine = 0;
  int blue = 0;
  int red_in_hole = 0;
  for (const auto& [key, image] : both) {
    const TileId id = TileId::from_key(key);
    if (id.level <= manifest_.layout.leaf_level) {
      const bool reached = id.level == 0 || id == TileId{1, 0, 0} || id == TileId{2, 1, 1};
      EXPECT_EQ(image.rgba == coarse.at(key).rgba, !reached) << id.text();
      // Also where quadrants of one side of a border only are filtered.
      for (std::size_t i = 3; i < image.rgba.size(); i += 4)
        ASSERT_EQ(image.rgba[i], coarse.at(key).rgba[i]) << id.text();
      continue;
    }
    // The quadrants of the one leaf, and those of its north-western one.
    EXPECT_EQ(squares.halvings(id.level) == 3 ? TileId(2, id.x / 2, id.y / 2) : TileId(3, id.x / 2, id.y / 2),
              squares.halvings(id.level) == 3 ? TileId(2, 1, 1) : TileId(3, 2, 2))
        << id.text();
    if (!squares.is_leaf_square(id.level)) continue;
    ++fine;
    for (int y = 0; y <= 32; ++y) {
      for (int x = 0; x <= 32; ++x) {
        // The node's place among the part's pixels, whose middles are at halves.
        const double column = static_cast<double>(id.x) * 32 + x + 2 - 140;
        const double row = static_cast<double>(id.y) * 32 + y + 2 - 140;
        const bool in_part = column > 2 && column < 38 && row > 2 && row < 38;
        const bool near_hole = column > 11 && column < 30 && row > 11 && row < 30;
        const bool in_hole = column > 16 && column < 25 && row > 16 && row < 25;
        EXPECT_EQ(image.at(x, y)[3], 255);
        if (in_part && !near_hole) {
          EXPECT_GT(image.at(x, y)[2], 150) << column << ' ' << row;
          ++blue;
        }
        if (in_hole) {
          EXPECT_GT(image.at(x, y)[0], 150) << column << ' ' << row;
          ++red_in_hole;
        }
      }
    }
  }
  EXPECT_EQ(fine, 4);
  EXPECT_GT(blue, 700);
  EXPECT_GT(red_in_hole, 60);
}

// Alone, it leaves what it does not cover without textures.
TEST_F(FineTexturesTest, APartAloneCoversNoMore) {
  write_photo(part_, part_spec(140, 140, 40, 40), false, meadow);
  const Images images = build_images({"--ortho", part_, "--texture-size", "32"});
  const int finest = manifest_.picture_layout(PictureKind::kTexture).leaf_level;
  std::size_t covered = 0;
  for (const auto& [key, image] : images) {
    if (TileId::from_key(key).level != finest) continue;
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 32; ++x) covered += image.at(x, y)[3] == 255 ? 1 : 0;
    }
  }
  EXPECT_NEAR(static_cast<double>(covered), 1600, 200);
}

TEST_F(FineTexturesTest, ThePlanForetellsThem) {
  write_photo(part_, part_spec(140, 60, 130, 130), false, meadow);
  const Words options{"--ortho", part_, "--texture-size", "32"};
  Words plan = options;
  plan.insert(plan.end(), {"--plan", "--json", report_});
  ASSERT_EQ(build(plan).exit_code, kDone);
  const json planned = json::parse(read_file(report_));
  const auto images = static_cast<double>(build_images(options).size());
  EXPECT_EQ(planned.at("texture_depth"), manifest_.texture_depth);
  EXPECT_GT(images, 20);
  EXPECT_NEAR(planned.at("textures").at("pictures").get<double>() / images, 1, 0.35);
}

TEST_F(FineTexturesTest, AreTheSameOnAnyNumberOfThreads) {
  const Words options{"--ortho", photo_, "--texture-size", "32"};
  Words one = options;
  one.insert(one.end(), {"--threads", "1"});
  const std::string alone = digest(one);
  fs::remove(tree_);
  EXPECT_EQ(digest(options), alone);
}

}  // namespace
}  // namespace tintree::test
