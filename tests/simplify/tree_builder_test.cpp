/// Whole trees: the same whatever the threads and interruptions, with measured errors that are true.

#include "simplify/tree_builder.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "tests/simplify/support.h"
#include "tests/support/temp_dir.h"

namespace tintree::simplify {
namespace {

using cache::Manifest;
using cache::TileWriter;
using codec::TileId;
using test::Terrain;

bool go_on(const std::string&, std::uint64_t, std::uint64_t) { return true; }

/// A terrain, the manifest of its tree and where to put it.
class TreeBuilderTest : public testing::Test {
 protected:
  TreeBuilderTest() { use(test::make_terrain(180, 140, test::rough_hills(30, 1, 0.01)), 16, 1); }

  void use(Terrain terrain, int tile_cells, double error_m, int levels_per_doubling = 1) {
    terrain_ = std::move(terrain);
    manifest_ = {};
    manifest_.layout = test::make_layout(terrain_, tile_cells, error_m, levels_per_doubling);
    manifest_.geotransform = {0, 1, 0, 0, 0, -1};
    manifest_.inputs = {{"dem.tif", 1, 1}};
    manifest_.samples_digest = terrain_.surface->digest();
  }

  std::string path(const std::string& name = "t.tintree") const { return dir_.file(name); }

  TileWriter create(const std::string& name = "t.tintree") { return TileWriter::create(path(name), manifest_).value(); }

  Expected<std::string> run(TileWriter& writer, const ProgressFn& progress = go_on) {
    auto levels = make_tiles(*terrain_.surface, manifest_, writer, progress);
    if (!levels) return tl::unexpected(levels.error());
    levels_ = std::move(*levels);
    if (auto measured = measure_tiles(*terrain_.surface, manifest_, writer, levels_, progress); !measured) {
      return tl::unexpected(measured.error());
    }
    return writer.finish();
  }

  /// The digest of a build in an arena of its own.
  std::string digest_with(int threads) {
    TileWriter writer = create("threads" + std::to_string(threads));
    return tbb::task_arena(threads).execute([&] { return run(writer).value(); });
  }

  /// Compares what is stored with the brute-force overlay of what is stored.
  void expect_true_figures() {
    auto writer = create();
    ASSERT_TRUE(run(writer).has_value());
    const auto store = cache::TileStore::open(path());
    ASSERT_TRUE(store.has_value());
    std::vector<double> largest(levels_.size());
    for (const cache::TileNode& node : store->bounds().nodes()) {
      SCOPED_TRACE(node.id.text());
      const auto tile = store->read(node.id);
      const auto mesh = store->read_mesh(node.id);
      ASSERT_TRUE(tile && mesh);
      const test::Overlay expected = test::overlay(terrain_.grid, manifest_.layout, node.id, *mesh);
      EXPECT_NEAR(tile->info.error_m, expected.max_m, 1e-9);
      EXPECT_NEAR(tile->info.border_error_m, expected.border_max_m, 1e-9);
      EXPECT_NEAR(tile->info.rms_m, expected.rms_m, 1e-9);
      EXPECT_EQ(tile->info.vertices, mesh->vertices.size());
      EXPECT_EQ(tile->info.triangles, mesh->triangles.size());
      auto& most = largest[static_cast<std::size_t>(node.id.level)];
      most = std::max(most, expected.max_m);
    }
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      EXPECT_NEAR(levels_[l].error_m, largest[l], 1e-9);
      EXPECT_EQ(levels_[l].level, static_cast<int>(l));
      EXPECT_EQ(levels_[l].bound_m, manifest_.layout.bound_m(static_cast<int>(l)));
      EXPECT_LE(levels_[l].error_m, levels_[l].bound_m);
    }
  }

  test::TempDir dir_;
  Terrain terrain_;
  Manifest manifest_;
  std::vector<LevelSummary> levels_;
};

TEST_F(TreeBuilderTest, GivesTheSameTreeWithAnyNumberOfThreads) {
  const std::string one = digest_with(1);
  EXPECT_EQ(one.size(), 32U);
  for (const int threads : {2, 4}) EXPECT_EQ(digest_with(threads), one) << threads;
}

TEST_F(TreeBuilderTest, GivesTheSameStripsWithAnyNumberOfThreads) {
  manifest_.method = "strip";
  const std::string one = digest_with(1);
  for (const int threads : {2, 4}) EXPECT_EQ(digest_with(threads), one) << threads;
}

TEST_F(TreeBuilderTest, GoesOnAfterAStop) {
  const std::string whole = digest_with(2);
  std::uint64_t steps = 0;
  {
    auto writer = create("all");
    ASSERT_TRUE(run(writer, [&](const std::string&, std::uint64_t, std::uint64_t) { return ++steps > 0; }).has_value());
  }
  // Stops while making tiles, at the end of that, and while measuring.
  const std::uint64_t tiles = test::tiles_of(manifest_.layout).size();
  ASSERT_GT(steps, tiles);
  for (const std::uint64_t last : {std::uint64_t{1}, tiles / 2, tiles, tiles + 1, tiles + (steps - tiles) / 2}) {
    SCOPED_TRACE(last);
    std::uint64_t count = 0;
    {
      auto writer = create();
      const auto stopped =
          run(writer, [&](const std::string&, std::uint64_t, std::uint64_t) { return ++count < last; });
      ASSERT_FALSE(stopped.has_value());
      EXPECT_EQ(stopped.error().code, ErrorCode::kStopped);
    }
    EXPECT_FALSE(cache::TileStore::open(path()).has_value());
    auto writer = TileWriter::resume(path(), manifest_).value();
    const std::size_t kept = writer.keys().value().size();
    EXPECT_GE(kept, std::min(last, tiles));
    std::uint64_t first_done = 0;
    const auto digest = run(writer, [&](const std::string& step, std::uint64_t done, std::uint64_t total) {
      EXPECT_LE(done, total);
      if (step == "tiles" && first_done == 0) first_done = done;
      return true;
    });
    ASSERT_TRUE(digest.has_value()) << digest.error().text();
    EXPECT_EQ(*digest, whole);
    EXPECT_TRUE(first_done == 0 || first_done == kept + 1) << first_done;
    std::filesystem::remove(path());
  }
}

TEST_F(TreeBuilderTest, StoresTrueFiguresOfTwoLevelsADoubling) {
  use(test::make_terrain(150, 60, test::rough_hills(30, 1, 0.05, 2)), 8, 2, 2);
  expect_true_figures();
}

TEST_F(TreeBuilderTest, KeepsEveryTileThatItReports) {
  // What lies in the files at the moment of a report is what a kill would leave.
  const std::string building = TileWriter::building_path(path());
  std::size_t looks = 0;
  auto writer = create();
  ASSERT_TRUE(make_tiles(*terrain_.surface, manifest_, writer, [&](const std::string&, std::uint64_t done, auto) {
                if (done % 5 != 0) return true;
                for (const char* suffix : {"", "-wal"}) {
                  std::filesystem::copy_file(building + suffix, TileWriter::building_path(path("copy")) + suffix,
                                             std::filesystem::copy_options::overwrite_existing);
                }
                EXPECT_EQ(TileWriter::resume(path("copy"), manifest_).value().keys()->size(), done);
                ++looks;
                return true;
              }).has_value());
  EXPECT_GT(looks, 10U);
}

TEST_F(TreeBuilderTest, StopsWhenAskedAndKeepsWhatIsMade) {
  const std::string whole = digest_with(2);
  StopFlag stop = false;
  std::uint64_t reported = 0;
  {
    auto writer = create();
    const auto stopped = make_tiles(
        *terrain_.surface, manifest_, writer,
        [&](const std::string&, std::uint64_t done, std::uint64_t) {
          reported = done;
          stop = done >= 20;
          return true;
        },
        &stop);
    ASSERT_FALSE(stopped.has_value());
    EXPECT_EQ(stopped.error().code, ErrorCode::kStopped);
    EXPECT_EQ(writer.keys()->size(), reported);
  }
  auto writer = TileWriter::resume(path(), manifest_).value();
  EXPECT_EQ(run(writer).value(), whole);
}

/// A DEM in a file that is read again and again, because not all of it is kept in memory: of its 79 blocks a view holds
/// 64 at most, and the cache with them a few more.
class ChangingInputTest : public TreeBuilderTest {
 protected:
  ChangingInputTest() {
    test::write_raster(dem_, {.columns = 20000, .rows = 30}, test::rough_hills(30, 0.1, 0));
    bytes_ = test::read_file(dem_);
    use(open(), 128, 4);
  }

  Terrain open() const {
    cache::set_raster_cache_bytes(0);
    auto source = std::make_shared<cache::RasterSource>(cache::RasterSource::open(dem_).value());
    return {test::read_grid(*source),
            ReferenceSurface::scan(std::make_shared<cache::HeightBlocks>(source, kCacheBytes), [](auto, auto) {
              return true;
            }).value()};
  }

  /// Changes the file under a build's hands, and lets it go on with the whole file again.
  void expect_failure_and_recovery(const std::function<void()>& damage, const std::string& message) {
    const std::string whole = digest_with(1);
    {
      auto writer = create();
      const auto failed = tbb::task_arena(1).execute([&] {
        return make_tiles(*terrain_.surface, manifest_, writer, [&](const std::string&, std::uint64_t done, auto) {
          if (done == 10) damage();
          return true;
        });
      });
      ASSERT_FALSE(failed.has_value());
      EXPECT_EQ(failed.error().code, ErrorCode::kIo);
      EXPECT_NE(failed.error().text().find(dem_), std::string::npos) << failed.error().text();
      EXPECT_NE(failed.error().text().find(message), std::string::npos) << failed.error().text();
      EXPECT_GE(writer.keys()->size(), 10U);
    }
    test::write_file(dem_, bytes_);
    terrain_ = open();
    auto writer = TileWriter::resume(path(), manifest_).value();
    EXPECT_EQ(run(writer).value(), whole);
  }

  static constexpr std::uint64_t kCacheBytes = 66 * 270 * 1024;
  std::string dem_ = path("dem.tif");
  std::string bytes_;
};

TEST_F(ChangingInputTest, TruncatedInTheMiddle) {
  expect_failure_and_recovery([&] { std::filesystem::resize_file(dem_, bytes_.size() / 4); }, "cannot read rows");
}

TEST_F(ChangingInputTest, OverwrittenInTheMiddle) {
  // Other heights of the same kind: nothing but the digest of the samples can tell.
  test::write_raster(path("other.tif"), {.columns = 20000, .rows = 30}, test::rough_hills(30, 0.1, 0, 9));
  expect_failure_and_recovery([&] { test::write_file(dem_, test::read_file(path("other.tif"))); }, "other heights");
}

TEST_F(TreeBuilderTest, ReportsProgressToTheEnd) {
  std::map<std::string, std::uint64_t> last;
  std::set<std::string> ended;
  auto writer = create();
  ASSERT_TRUE(run(writer, [&](const std::string& step, std::uint64_t done, std::uint64_t total) {
                EXPECT_EQ(done, last[step] + 1) << step;
                last[step] = done;
                if (done == total) ended.insert(step);
                return true;
              }).has_value());
  EXPECT_EQ(last["tiles"], test::tiles_of(manifest_.layout).size());
  EXPECT_TRUE(ended.contains("tiles"));
  EXPECT_EQ(ended.size(), last.size());
}

TEST_F(TreeBuilderTest, StoresTrueFigures) { expect_true_figures(); }

TEST_F(TreeBuilderTest, StoresTrueFiguresOfDeepTrees) {
  use(test::make_terrain(200, 50, test::rough_hills(30, 1, 0.05, 2)), 8, 2);
  ASSERT_GT(manifest_.layout.leaf_level, 3);
  expect_true_figures();
}

TEST_F(TreeBuilderTest, StoresTrueFiguresWhereLeavesLackTiles) {
  // The last column and row of surface lie on sides of leaves that hold none.
  const auto hills = test::rough_hills(30, 1, 0);
  use(test::make_terrain(129, 129, [&](int c, int r) { return c > 32 || r > 48 ? test::kMissing : hills(c, r); }), 8,
      2);
  expect_true_figures();
}

TEST_F(TreeBuilderTest, StoresTrueFiguresOfOneTile) {
  use(test::make_terrain(2, 2, [](int c, int r) { return c + 3.0 * r; }), 8, 0.5);
  expect_true_figures();
  EXPECT_EQ(levels_.size(), 1U);
  EXPECT_EQ(levels_[0].triangles, 2U);
}

TEST_F(TreeBuilderTest, RefusesAnUnknownMethod) {
  auto writer = create();
  manifest_.method = "tun";
  const auto levels = make_tiles(*terrain_.surface, manifest_, writer, go_on);
  ASSERT_FALSE(levels.has_value());
  EXPECT_EQ(levels.error().code, ErrorCode::kUsage);
}

TEST_F(TreeBuilderTest, OwnsUpToABrokenBound) {
  auto writer = create();
  auto levels = make_tiles(*terrain_.surface, manifest_, writer, go_on);
  ASSERT_TRUE(levels.has_value());
  Manifest stricter = manifest_;
  stricter.layout.leaf_error_m /= 4;
  const auto measured = measure_tiles(*terrain_.surface, stricter, writer, *levels, go_on);
  ASSERT_FALSE(measured.has_value());
  EXPECT_EQ(measured.error().code, ErrorCode::kCheckFailed);
  EXPECT_NE(measured.error().text().find("tile "), std::string::npos);
}

TEST(ChooseHeightSteps, TakesAQuarterOfTheBound) {
  const Terrain terrain = test::make_terrain(65, 65, test::rough_hills(100, 1, 0));
  const codec::TreeLayout layout = test::make_layout(terrain, 16, 0.8);
  ASSERT_EQ(layout.z_step_m.size(), 3U);
  for (int level = 0; level < 3; ++level)
    EXPECT_EQ(layout.z_step_m[static_cast<std::size_t>(level)], layout.bound_m(level) / 4);
}

/// The refusal of a layout, which has the code and the words and, where it names an error, works with that.
void expect_refused(const Terrain& terrain, codec::TreeLayout layout, ErrorCode code,
                    const std::vector<std::string>& words) {
  const auto steps = choose_height_steps(*terrain.surface, layout);
  ASSERT_FALSE(steps.has_value());
  EXPECT_EQ(steps.error().code, code);
  const std::string text = steps.error().text();
  for (const std::string& word : words) EXPECT_NE(text.find(word), std::string::npos) << word << " not in: " << text;
  const auto at = text.find("--error ");
  if (at == std::string::npos) return;
  layout.leaf_error_m = std::stod(text.substr(at + 8));
  EXPECT_TRUE(choose_height_steps(*terrain.surface, layout).has_value()) << "the advice does not help: " << text;
}

TEST(ChooseHeightSteps, SaysWhatErrorWouldDo) {
  const Terrain terrain = test::make_terrain(65, 65, [](int c, int) { return c == 10 ? 131072.0 : 0.0; });
  codec::TreeLayout layout = test::make_layout(terrain, 32, 1);
  layout.leaf_error_m = 0.001;
  expect_refused(terrain, layout, ErrorCode::kBadData,
                 {"differ by up to 131072 m within a tile", "--error ", "nodata"});
}

TEST(ChooseHeightSteps, SaysWhatErrorWouldDoFarFromZero) {
  for (const double height_m : {1e6, -1e6}) {
    const Terrain terrain = test::make_terrain(65, 65, [=](int c, int) { return height_m + 0.25 * (c % 2); });
    codec::TreeLayout layout = test::make_layout(terrain, 32, 1);
    layout.leaf_error_m = 0.001;
    EXPECT_TRUE(choose_height_steps(*terrain.surface, layout).has_value());
    layout.leaf_error_m = 1e-6;
    expect_refused(terrain, layout, ErrorCode::kBadData, {"lie up to 1e+06 m from 0", "--error ", "nodata"});
  }
}

TEST(ChooseHeightSteps, NamesUnmarkedNodata) {
  const Terrain terrain =
      test::make_exact_terrain(65, 65, [](int c, int r) { return c == r ? -3.4028234663852886e38 : 5.0; });
  codec::TreeLayout layout;
  layout.columns = layout.rows = 65;
  layout.leaf_error_m = 1;
  expect_refused(terrain, layout, ErrorCode::kBadData, {"-a_nodata"});
}

TEST(ChooseHeightSteps, RefusesErrorsOutOfAllRange) {
  const Terrain terrain = test::make_terrain(65, 65, [](int, int) { return 0.0; });
  codec::TreeLayout layout = test::make_layout(terrain, 32, 1);
  for (const double error_m : {1e-40, 5e-324, 1e40, 1e308}) {
    layout.leaf_error_m = error_m;
    expect_refused(terrain, layout, ErrorCode::kUsage, {error_m < 1 ? "too small" : "too large", "--error "});
  }
}

}  // namespace
}  // namespace tintree::simplify
