/// A build with photos and normal maps, from the command line.

#include <cmath>

#include "cache/tile_pictures.h"
#include "codec/texture_codec.h"
#include "tests/apps/build_support.h"
#include "tests/support/test_photo.h"

namespace tintree::test {
namespace {

using cache::PictureKind;
using nlohmann::json;

class OrthoTest : public BuildTest {
 protected:
  OrthoTest() : photo_(dir_.file("photo.tif")) {
    write_photo(photo_, {.columns = 90, .rows = 70, .dx = 10, .dy = 10}, false, meadow);
  }

  json report_of(const Words& more) const {
    EXPECT_NE(digest(more), "");
    return json::parse(read_file(report_));
  }
  void remove_tree() const { fs::remove(tree_); }

  std::string photo_;
};

TEST_F(OrthoTest, PutsPicturesIntoTheTree) {
  const json report = report_of({"--ortho", photo_, "--normal-maps", "--texture-size", "32"});
  EXPECT_EQ(report.at("textures").at("pictures"), report.at("tiles"));
  EXPECT_EQ(report.at("normal_maps").at("pictures"), report.at("tiles"));
  const auto store = cache::TileStore::open(tree_);
  ASSERT_TRUE(store.has_value());
  EXPECT_EQ(store->manifest().picture_size(PictureKind::kTexture), 33);
  EXPECT_EQ(store->manifest().picture_size(PictureKind::kNormal), 33);
  EXPECT_EQ(*store->digest(), store->manifest().digest);
  // A leaf's texels lie at the DEM's samples, which are the photo's pixels.
  const auto payload = store->read_picture(PictureKind::kTexture, {store->manifest().layout.leaf_level, 1, 1});
  ASSERT_TRUE(payload.has_value() && payload->has_value());
  const auto image = codec::find_texture_codec("bc1")->decode(**payload, 33);
  double squares = 0;
  for (int y = 0; y < 33; ++y) {
    for (int x = 0; x < 33; ++x) {
      for (std::size_t k = 0; k < 3; ++k) squares += std::pow(image->at(x, y)[k] - meadow(32 + x, 32 + y)[k], 2);
    }
  }
  EXPECT_LT(std::sqrt(squares / (33 * 33 * 3)), 8);
}

// Tiles on the same square have one picture, the one that a tree with one level a doubling has there.
TEST_F(OrthoTest, TwoLevelsADoublingShareTheirPictures) {
  const Words options{"--ortho", photo_, "--normal-maps", "--texture-size", "32"};
  const json one_report = report_of(options);
  fs::rename(tree_, dir_.file("one.tintree"));
  Words more = options;
  more.insert(more.end(), {"--levels-per-doubling", "2"});
  const json two_report = report_of(more);
  EXPECT_GT(two_report.at("tiles"), one_report.at("tiles"));
  const auto one = cache::TileStore::open(dir_.file("one.tintree"));
  const auto two = cache::TileStore::open(tree_);
  ASSERT_TRUE(one.has_value() && two.has_value());
  for (const PictureKind kind : cache::kPictureKinds) {
    EXPECT_EQ(two->picture_keys(kind)->size(), one->picture_keys(kind)->size());
    for (const cache::TileNode& node : two->bounds().nodes()) {
      const codec::TileId on_square{two->manifest().layout.halvings(node.id.level), node.id.x, node.id.y};
      const auto expected = one->read_picture(kind, on_square);
      const auto found = two->read_picture(kind, two->manifest().layout.picture_tile(node.id));
      ASSERT_TRUE(expected && *expected && found && *found) << node.id.text();
      EXPECT_EQ(**found, **expected) << node.id.text();
    }
  }
  for (const cache::TileNode& node : two->bounds().nodes()) {
    const auto loaded = cache::load_pictures(*two, node.id, true);
    ASSERT_TRUE(loaded.has_value()) << loaded.error().text();
    EXPECT_EQ(loaded->colors.size, 33);
    EXPECT_EQ(loaded->directions.size, 33);
  }
}

TEST_F(OrthoTest, JpegTakesLessOfTheDisk) {
  const std::uint64_t bc1 = report_of({"--ortho", photo_, "--texture-size", "128"}).at("textures").at("bytes");
  remove_tree();
  const std::uint64_t jpeg =
      report_of({"--ortho", photo_, "--texture-size", "128", "--texture-codec", "jpeg"}).at("textures").at("bytes");
  EXPECT_LT(jpeg, bc1);
}

TEST_F(OrthoTest, AFinerPhotoGetsLargerTextures) {
  write_photo(photo_, {.columns = 2000, .rows = 1500, .dx = 0.5, .dy = 0.5}, false, meadow);
  EXPECT_EQ(report_of({"--ortho", photo_}).at("texture_size"), 512);
}

TEST_F(OrthoTest, ThePlanIsNear) {
  const Words options{"--ortho", photo_, "--normal-maps", "--texture-size", "32"};
  Words plan = options;
  plan.insert(plan.end(), {"--plan", "--json", report_});
  ASSERT_EQ(build(plan).exit_code, kDone);
  const json planned = json::parse(read_file(report_));
  const json made = report_of(options);
  for (const char* kind : {"textures", "normal_maps"}) {
    EXPECT_EQ(planned.at(kind).at("pictures"), made.at(kind).at("pictures"));
    const double ratio = planned.at(kind).at("bytes").get<double>() / made.at(kind).at("bytes").get<double>();
    EXPECT_NEAR(ratio, 1, 0.15) << kind;
  }
  EXPECT_NEAR(planned.at("bytes").get<double>() / made.at("bytes").get<double>(), 1, 0.3);
}

TEST_F(OrthoTest, DigestCoversPicturesAndNotThreads) {
  const std::string plain = digest();
  remove_tree();
  const std::string one = digest({"--ortho", photo_, "--threads", "1"});
  remove_tree();
  const std::string two = digest({"--ortho", photo_, "--threads", "3"});
  remove_tree();
  write_photo(photo_, {.columns = 90, .rows = 70, .dx = 10, .dy = 10}, false,
              [](int c, int r) { return meadow(c + 5, r); });
  const std::string other = digest({"--ortho", photo_});
  EXPECT_EQ(one, two);
  EXPECT_NE(one, plain);
  EXPECT_NE(one, other);
}

TEST_F(OrthoTest, ResumeRefusesAChangedPhotoByName) {
  const Words options{"--ortho", photo_};
  ASSERT_NE(digest(options), "");
  write_photo(photo_, {.columns = 90, .rows = 71, .dx = 10, .dy = 10}, false, meadow);
  Words resume = options;
  resume.emplace_back("--resume");
  const ProgramResult r = build(resume);
  EXPECT_EQ(r.exit_code, kUsage) << r.all();
  expect_message(r, {"--ortho", photo_});
  const ProgramResult without = build({"--resume"});
  EXPECT_EQ(without.exit_code, kUsage);
  expect_message(without, {"--ortho"});
}

TEST_F(OrthoTest, RefusesNonsense) {
  expect_refused({"--texture-depth", "2"}, kUsage, {"--texture-depth", "--ortho"});
  expect_refused({"--texture-size", "32"}, kUsage, {"--texture-size", "--ortho"});
  expect_refused({"--ortho", photo_, "--texture-size", "33"}, kUsage, {"--texture-size", "power of two"});
  expect_refused({"--ortho", dir_.file("none.tif")}, kIo, {"none.tif", "no such file"});
  write_file(photo_, "no picture");
  expect_refused({"--ortho", photo_}, kBadData, {photo_});
}

}  // namespace
}  // namespace tintree::test
