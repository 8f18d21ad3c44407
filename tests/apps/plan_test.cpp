/// --plan: tells what a build will do, and does nothing.

#include "tests/apps/build_support.h"

namespace tintree::test {
namespace {

using nlohmann::json;

class PlanTest : public BuildTest {
 protected:
  json plan(Words more = {}) const {
    more.insert(more.end(), {"--plan", "--json", report_});
    const ProgramResult r = build(more);
    EXPECT_EQ(r.exit_code, kDone) << r.all();
    return json::parse(read_file(report_));
  }
};

TEST_F(PlanTest, ComesCloseToTheBuild) {
  write_raster(dem_, {.columns = 700, .rows = 500, .dx = 10, .dy = 10},
               [](int c, int r) { return c > 550 && r > 300 ? kMissing : hills(c, r, 50 + c / 5.0); });
  const json planned = plan();
  EXPECT_FALSE(fs::exists(tree_));
  ASSERT_NE(digest(), "");
  const json built = json::parse(read_file(report_));
  for (const char* key : {"vertices", "triangles", "payload_bytes", "bytes"}) {
    EXPECT_NEAR(planned.at(key).get<double>(), built.at(key).get<double>(), 0.25 * built.at(key).get<double>()) << key;
  }
  for (const char* key : {"samples", "error_m", "tile_cells", "method", "threads"}) {
    EXPECT_EQ(planned.at(key), built.at(key)) << key;
  }
  EXPECT_EQ(planned.at("levels").size(), built.at("levels").size());
  EXPECT_GE(planned.at("tiles"), built.at("tiles")) << "squares of nodata count in a plan";
  std::uint64_t sampled = 0;
  for (const json& level : planned.at("levels")) sampled += level.at("tiles_sampled").get<std::uint64_t>();
  EXPECT_LT(sampled, planned.at("tiles")) << "this was to be a sample";
  for (const char* key : {"seconds", "make_seconds", "thread_seconds", "peak_rss_bytes"}) {
    EXPECT_GT(planned.at(key), 0) << key;
  }
}

/// Tiles of method wavelet build on those above them, of which a sample has none.
TEST_F(PlanTest, ComesCloseForTilesThatBuildOnOthers) {
  write_raster(dem_, {.columns = 700, .rows = 500, .dx = 10, .dy = 10},
               [](int c, int r) { return c > 550 && r > 300 ? kMissing : hills(c, r, 50 + c / 5.0); });
  for (const std::string criterion : {"rms", "max"}) {
    SCOPED_TRACE(criterion);
    const Words options = {"--method", "wavelet", "--criterion", criterion, "--tile", "64", "--overwrite"};
    const json planned = plan(options);
    ASSERT_NE(digest(options), "");
    const json built = json::parse(read_file(report_));
    for (const char* key : {"vertices", "triangles", "payload_bytes"}) {
      EXPECT_NEAR(planned.at(key).get<double>() / built.at(key).get<double>(), 1, 0.2) << key;
    }
    EXPECT_LT(planned.at("levels").back().at("tiles_sampled"), planned.at("levels").back().at("tiles"));
  }
}

TEST_F(PlanTest, OfAllTilesIsRight) {
  const json planned = plan();
  ASSERT_NE(digest(), "");
  const json built = json::parse(read_file(report_));
  for (const char* key : {"tiles", "vertices", "triangles", "payload_bytes"}) EXPECT_EQ(planned.at(key), built.at(key));
}

TEST_F(PlanTest, OfSeveralDemsWithFilledHolesIsRight) {
  write_raster(dem_, {.columns = 90, .rows = 70, .dx = 10, .dy = 10},
               [](int c, int r) { return c > 20 && c < 60 && r > 30 ? kMissing : hills(c, r); });
  const std::string east = dir_.file("east.tif");
  write_raster(east, {.columns = 50, .rows = 70, .dx = 10, .dy = 10, .west = 1800},
               [](int c, int r) { return hills(c + 80, r); });
  const Words input = {"--nodata", "fill", east};
  const json planned = plan(input);
  EXPECT_EQ(std::distance(fs::directory_iterator(dir_.path()), {}), 3) << "only DEMs and report are left";
  ASSERT_NE(digest(input), "");
  const json built = json::parse(read_file(report_));
  for (const char* key : {"samples", "tiles", "vertices", "triangles", "payload_bytes"}) {
    EXPECT_EQ(planned.at(key), built.at(key)) << key;
  }
}

TEST_F(PlanTest, WritesNothingAndNeedsNoOutput) {
  const ProgramResult r = run_program(TINTREE_BUILD, {dem_, "--plan"});
  EXPECT_EQ(r.exit_code, kDone) << r.all();
  for (const char* word : {"level", "tiles", "MiB", " s on ", "nothing was written"}) {
    EXPECT_NE(r.out.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(dir_.path()), {}), 1) << "only the DEM is there";
}

TEST_F(PlanTest, LeavesATreeAndAnUnfinishedBuildAlone) {
  write_file(tree_, "precious");
  write_file(cache::TileWriter::building_path(tree_), "work");
  plan();
  EXPECT_EQ(read_file(tree_), "precious");
  EXPECT_EQ(read_file(cache::TileWriter::building_path(tree_)), "work");
}

TEST_F(PlanTest, HeedsThreadsAndMemory) {
  EXPECT_EQ(plan({"--threads", "3"}).at("threads"), 3);
  const ProgramResult r = build({"--plan", "--memory", "10"});
  EXPECT_EQ(r.exit_code, kUsage) << r.all();
  expect_message(r, {"--memory"});
}

TEST_F(PlanTest, RefusesWhatABuildRefuses) {
  for (const Words& error : {Words{"1e-40", "too small"}, Words{"1e40", "too large"}}) {
    const ProgramResult scale = build({"--plan", "--error", error[0]});
    EXPECT_EQ(scale.exit_code, kUsage) << scale.all();
    expect_message(scale, {error[1], "--error "});
  }
  const ProgramResult fine = build({"--plan", "--error", "1e-9"});
  EXPECT_EQ(fine.exit_code, kBadData) << fine.all();
  expect_message(fine, {dem_, "heights differ by up to", "--error "});
  const ProgramResult folder = run_program(TINTREE_BUILD, {dem_, "--plan", "-o", dir_.file("no/such.tintree")});
  EXPECT_EQ(folder.exit_code, kIo) << folder.all();
  expect_message(folder, {"no folder", dir_.file("no")});
  write_raster(dem_, {.columns = 90, .rows = 70}, [](int, int) { return kMissing; });
  const ProgramResult empty = build({"--plan"});
  EXPECT_EQ(empty.exit_code, kBadData) << empty.all();
  expect_message(empty, {dem_, "no surface"});
  fs::remove(dem_);
  const ProgramResult r = build({"--plan"});
  EXPECT_EQ(r.exit_code, kIo) << r.all();
  expect_message(r, {dem_, "no such file"});
}

}  // namespace
}  // namespace tintree::test
