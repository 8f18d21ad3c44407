/// Damage to textures and normal maps, checksums and all: the audit finds and names each.

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "codec/texture_codec.h"
#include "tests/apps/build_support.h"
#include "tests/support/picture_change.h"
#include "tests/support/test_photo.h"

namespace tintree::test {
namespace {

using cache::PictureKind;
using codec::TileId;
using nlohmann::json;

/// A photo whose contrast is in its light, as most photos' is.
std::array<std::uint8_t, 4> furrows(int column, int row) {
  const double light = 0.5 + 0.2 * std::sin(column / 3.0 + row / 8.0) + 0.2 * std::cos(row / 4.0);
  const auto part = [&](double share) { return static_cast<std::uint8_t>(std::lround(255 * share * light)); };
  return {part(1), part(0.9), part(0.7), 255};
}

class AuditPicturesTest : public BuildTest {
 protected:
  AuditPicturesTest() : photo_(dir_.file("photo.tif")) {
    write_photo(photo_, {.columns = 90, .rows = 70, .dx = 10, .dy = 10}, false, furrows);
    const ProgramResult r = build({"--ortho", photo_, "--normal-maps", "--texture-size", "32"});
    EXPECT_EQ(r.exit_code, kDone) << r.all();
  }

  ProgramResult audit(const Words& more = {}) const {
    Words all{tree_, "--dem", dem_, "--quiet", "--hausdorff-tiles", "0", "--json", report_};
    all.insert(all.end(), more.begin(), more.end());
    return run_program(TINTREE_AUDIT, all);
  }

  /// Expects the audit to fail with a violation of the tile's picture that says `what`.
  void expect_found(const TileId& id, const std::string& what, const Words& more = {}) const {
    const ProgramResult r = audit(more);
    EXPECT_EQ(r.exit_code, 1) << r.all();
    EXPECT_NE(r.err.find("tile " + id.text()), std::string::npos) << r.err;
    const json list = json::parse(read_file(report_)).at("violation_list");
    const bool named = std::ranges::any_of(list, [&](const json& v) {
      return v.at("kind") == "picture" && v.at("tile") == id.text() &&
             v.at("message").get<std::string>().find(what) != std::string::npos;
    });
    EXPECT_TRUE(named) << what << " not in " << list.dump(1);
  }

  std::vector<std::byte> payload(PictureKind kind, const TileId& id) const {
    const auto store = cache::TileStore::open(tree_);
    return **store->read_picture(kind, id);
  }

  void replace(PictureKind kind, const TileId& id, std::span<const std::byte> bytes) const {
    replace_picture(tree_, kind, id, bytes);
  }

  /// Moves a texture's rows up by one.
  void move_rows(const TileId& id) const {
    const codec::TextureCodec& codec = *codec::find_texture_codec("bc1");
    auto image = *codec.decode(payload(PictureKind::kTexture, id), 33);
    image.rgba.erase(image.rgba.begin(), image.rgba.begin() + 4 * 33);
    image.rgba.insert(image.rgba.end(), image.rgba.end() - 4 * 33, image.rgba.end());
    replace(PictureKind::kTexture, id, *codec.encode(image));
  }

  std::string photo_;
};

TEST_F(AuditPicturesTest, PassesAGoodTree) {
  const ProgramResult r = audit({"--ortho", photo_});
  EXPECT_EQ(r.exit_code, 0) << r.all();
}

// A leaf is held against the photo, any tile against its parent.
TEST_F(AuditPicturesTest, KnowsWhichTilesShareAPicture) {
  ASSERT_EQ(
      build({"--ortho", photo_, "--normal-maps", "--texture-size", "32", "--levels-per-doubling", "2", "--overwrite"})
          .exit_code,
      kDone);
  const ProgramResult sound = audit({"--ortho", photo_});
  EXPECT_EQ(sound.exit_code, 0) << sound.all();
  move_rows({3, 1, 1});
  expect_found({3, 1, 1}, "rows of texels off");
  // The finer tile on the square of 1/0/1 has a picture of its own now.
  replace(PictureKind::kTexture, {2, 0, 1}, payload(PictureKind::kTexture, {1, 0, 1}));
  EXPECT_EQ(audit().exit_code, 1);
  EXPECT_NE(read_file(report_).find("or has its parent's"), std::string::npos);
}

// Finer textures are held against the photo, and against those above them; missing ones are missed.
TEST_F(AuditPicturesTest, LooksIntoTheLeaves) {
  write_photo(photo_, {.columns = 180, .rows = 140, .dx = 5, .dy = 5}, false, furrows);
  ASSERT_EQ(build({"--ortho", photo_, "--texture-size", "32", "--overwrite"}).exit_code, kDone);
  const ProgramResult sound = audit({"--ortho", photo_});
  EXPECT_EQ(sound.exit_code, 0) << sound.all();
  const TileId fine{3, 1, 1};
  const auto whole = payload(PictureKind::kTexture, fine);
  move_rows(fine);
  expect_found(fine, "1 rows of texels off the photo", {"--ortho", photo_});
  expect_found(fine, "1 rows of texels off its parent's");
  replace(PictureKind::kTexture, fine, std::span(whole).first(10));
  expect_found(fine, "its texture");
  replace(PictureKind::kTexture, fine, whole);
  for (int q = 0; q < 4; ++q) {
    const TileId quadrant{3, 2 + static_cast<std::uint32_t>(q % 2), 2 + static_cast<std::uint32_t>(q / 2)};
    remove_texture(tree_, quadrant);
  }
  expect_found({2, 1, 1}, "lacks the finer textures", {"--ortho", photo_});
}

TEST_F(AuditPicturesTest, FindsRowsMovedByOne) {
  const TileId leaf{2, 1, 1};
  const auto whole = payload(PictureKind::kTexture, leaf);
  move_rows(leaf);
  expect_found(leaf, "1 rows of texels off the photo", {"--ortho", photo_});
  expect_found(leaf, "1 rows of texels off its parent's");
  replace(PictureKind::kTexture, leaf, whole);
  const TileId middle{1, 0, 0};
  move_rows(middle);
  expect_found(middle, "1 rows of texels off its parent's");
}

TEST_F(AuditPicturesTest, FindsAFlippedByte) {
  for (const auto& [kind, name] : {std::pair(PictureKind::kTexture, "texture"), {PictureKind::kNormal, "normal map"}}) {
    const TileId id{2, 0, 1};
    std::string file = read_file(tree_);
    const auto bytes = payload(kind, id);
    // Where the payload lies contiguously: its first bytes may be on another page.
    const std::string tail(reinterpret_cast<const char*>(bytes.data()) + bytes.size() - 40, 40);
    const std::size_t at = file.find(tail);
    ASSERT_NE(at, std::string::npos);
    file[at + 20] = static_cast<char>(file[at + 20] ^ 0x10);
    write_file(tree_, file);
    expect_found(id, name);
  }
}

TEST_F(AuditPicturesTest, FindsPicturesOfAnotherTile) {
  const TileId id{2, 1, 0};
  for (const PictureKind kind : cache::kPictureKinds) {
    const auto own = payload(kind, id);
    replace(kind, id, payload(kind, {2, 0, 1}));
    expect_found(id, kind == PictureKind::kTexture ? "its texture" : "its normal map", {"--ortho", photo_});
    replace(kind, id, own);
  }
  EXPECT_EQ(audit({"--ortho", photo_}).exit_code, 0);
}

TEST_F(AuditPicturesTest, FindsWhatDoesNotDecode) {
  const TileId id{2, 0, 0};
  auto bytes = payload(PictureKind::kTexture, id);
  bytes.resize(bytes.size() / 2);
  replace(PictureKind::kTexture, id, bytes);
  expect_found(id, "its texture");
}

}  // namespace
}  // namespace tintree::test
