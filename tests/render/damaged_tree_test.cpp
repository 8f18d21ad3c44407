/// What becomes of the file while it is being viewed, and of what is damaged in it: the picture goes on.

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sqlite3.h>

#include "render/terrain_scene.h"
#include "tests/render/analytic_tree.h"
#include "tests/render/osmesa_test.h"
#include "tests/support/picture_change.h"
#include "tests/support/run_program.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

using codec::TileId;

constexpr int kSize = 128;

class DamagedTreeTest : public OsMesaTest {
 protected:
  DamagedTreeTest() {
    tree_.color = [](const TileId& id) { return id.level == 2 ? kGreen : kBlue; };
  }

  void open() {
    store_.emplace(std::move(*cache::TileStore::open(path_)));
    scene_ = std::move(*TerrainScene::create(gl_, *store_, {}));
  }
  void close() {
    scene_.reset();
    store_.reset();
    std::filesystem::remove(path_);
  }

  /// Straight down on the middle of a leaf, whose ground fills the picture.
  static Camera above(const TileId& leaf, double height_m = 300) {
    const glm::dvec3 middle(320.0 * leaf.x + 160, -320.0 * leaf.y - 160, 0);
    Camera c;
    c.eye = middle + glm::dvec3(0, 0, height_m);
    c.target = middle;
    c.width_px = c.height_px = kSize;
    return c;
  }
  static Camera overview() { return above({2, 1, 1}, 20000); }

  Picture draw(const Camera& camera, const LodCut& cut) {
    const auto target = OffscreenTarget::create(gl_, kSize, kSize, 1);
    Style style;
    style.background = glm::vec3(1, 0, 1);
    scene_->draw(*target, camera, cut, style);
    return target->read_picture();
  }
  Picture settled(const Camera& camera) {
    scene_->cut_options().pixel_error = camera.eye.z < 1000 ? 0 : 1;
    const auto cut = scene_->settle(camera);
    EXPECT_TRUE(cut) << cut.error().text();
    return draw(camera, *cut);
  }

  static int count_magenta(const Picture& p) {
    int count = 0;
    for (int i = 0; i < kSize * kSize; ++i)
      count += p.at(i % kSize, i / kSize) == std::array<std::uint8_t, 3>{255, 0, 255};
    return count;
  }
  /// Which of its two colours the middle of the picture has.
  static std::array<std::uint8_t, 3> color_of(const Picture& p) {
    const auto [red, green, blue] = p.at(kSize / 2, kSize / 2);
    return green > blue ? kGreen : kBlue;
  }

  void change(const std::string& sql) const {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
  }

  /// Looks at the whole, then spoils the file, then flies over all leaves and back: ground everywhere, and no tile is
  /// reported twice. Returns the reports.
  std::vector<Error> fly_while(const std::function<void()>& spoil) {
    tree_.write(path_);
    open();
    settled(overview());
    spoil();
    std::vector<Error> all;
    std::set<std::string> said;
    for (int round = 0; round < 2; ++round) {
      for (const TileId& id : tree_.tiles()) {
        if (id.level < 2 || id.x > 3 || id.y > 3) continue;
        EXPECT_EQ(count_magenta(settled(above(id))), 0) << id.text();
        for (Error& e : scene_->take_errors()) {
          EXPECT_TRUE(said.insert(e.text()).second) << e.text();
          EXPECT_EQ(round, 0) << e.text();
          all.push_back(std::move(e));
        }
      }
    }
    return all;
  }

  static constexpr std::array<std::uint8_t, 3> kGreen{40, 200, 40};
  static constexpr std::array<std::uint8_t, 3> kBlue{40, 40, 200};

  test::TempDir dir_;
  std::string path_ = dir_.file("tree.tintree");
  test::AnalyticTree tree_;
  std::optional<cache::TileStore> store_;
  std::unique_ptr<TerrainScene> scene_;
};

TEST_F(DamagedTreeTest, ADeletedFileIsStillRead) {
  EXPECT_TRUE(fly_while([this] { std::filesystem::remove(path_); }).empty());
  EXPECT_EQ(color_of(settled(above({2, 1, 1}))), kGreen);
}

TEST_F(DamagedTreeTest, AFileThatIsReplacedIsStillRead) {
  const auto errors = fly_while([this] {
    test::write_file(path_ + ".new", "something else\n");
    std::filesystem::rename(path_ + ".new", path_);
  });
  EXPECT_TRUE(errors.empty());
}

TEST_F(DamagedTreeTest, OfATruncatedFileWhatIsThereIsDrawn) {
  for (const double share : {0.0, 0.02, 0.3, 0.6}) {
    const auto errors = fly_while([this, share] {
      const auto bytes = static_cast<double>(std::filesystem::file_size(path_));
      std::filesystem::resize_file(path_, static_cast<std::uintmax_t>(share * bytes));
    });
    ASSERT_FALSE(errors.empty()) << share;
    for (const Error& e : errors) {
      EXPECT_NE(e.text().find(path_), std::string::npos) << e.text();
      EXPECT_NE(e.text().find("build"), std::string::npos) << e.text();  // What to do.
    }
    close();
  }
}

TEST_F(DamagedTreeTest, OfAFileOverwrittenWithNonsenseNothingNewIsDrawn) {
  const auto errors =
      fly_while([this] { test::write_file(path_, std::string(std::filesystem::file_size(path_), 'x')); });
  ASSERT_FALSE(errors.empty());
  for (const Error& e : errors) EXPECT_NE(e.text().find(path_), std::string::npos) << e.text();
}

TEST_F(DamagedTreeTest, ATextureThatDoesNotDecodeIsDrawnFromTheParent) {
  const TileId bad{2, 1, 1};
  const auto whole = tree_.texture(bad);
  for (const bool wrong_checksum : {false, true}) {
    tree_.write(path_);
    test::replace_picture(path_, cache::PictureKind::kTexture, bad, std::span(whole).first(whole.size() / 2));
    if (wrong_checksum) change("UPDATE texture SET checksum = 1 - checksum WHERE key = " + std::to_string(bad.key()));
    open();
    for (int i = 0; i < 3; ++i) {
      const Picture p = settled(above(bad));
      EXPECT_EQ(count_magenta(p), 0);
      EXPECT_EQ(color_of(p), kBlue);
      const auto errors = scene_->take_errors();
      ASSERT_EQ(errors.size(), i == 0 ? 1U : 0U);
      if (i > 0) continue;
      EXPECT_NE(errors[0].text().find("texture of tile " + bad.text()), std::string::npos) << errors[0].text();
      EXPECT_NE(errors[0].text().find(path_), std::string::npos) << errors[0].text();
    }
    EXPECT_EQ(color_of(settled(above({2, 2, 1}))), kGreen);
    close();
  }
}

}  // namespace
}  // namespace tintree::render
