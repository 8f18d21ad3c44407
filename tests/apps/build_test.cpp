/// The build as a program: what it makes, what it refuses and how it says so.

#include "tests/apps/build_support.h"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "cache/drawable_tile.h"
#include "cache/strip_shape.h"
#include "cache/tile_store.h"
#include "codec/coded_strip_mesh.h"

namespace tintree::test {
namespace {

using nlohmann::json;

TEST_F(BuildTest, BuildsATreeAndReportsIt) {
  const ProgramResult r =
      run_program(TINTREE_BUILD, {dem_, "-o", tree_, "--tile", "32", "--error", "2", "--json", report_});
  ASSERT_EQ(r.exit_code, kDone) << r.all();
  EXPECT_NE(r.out.find("digest "), std::string::npos) << r.out;
  const json found = json::parse(read_file(report_));
  for (const char* key :
       {"seconds",         "read_seconds",         "make_seconds",   "measure_seconds", "threads",       "samples",
        "valid_samples",   "samples_per_second",   "peak_rss_bytes", "error_m",         "method",        "tile_cells",
        "tiles",           "tiles_made",           "vertices",       "triangles",       "payload_bytes", "bytes",
        "bits_per_sample", "file_bits_per_sample", "digest",         "levels"}) {
    EXPECT_TRUE(found.contains(key)) << key;
  }
  EXPECT_EQ(found.at("samples"), 90 * 70);
  EXPECT_EQ(found.at("error_m"), 2);
  EXPECT_EQ(found.at("bytes"), fs::file_size(tree_));
  ASSERT_EQ(found.at("levels").size(), 3U);
  std::uint64_t tiles = 0;
  for (const json& level : found.at("levels")) {
    for (const char* key : {"level", "tiles", "vertices", "triangles", "bytes", "bits_per_vertex", "bound_m",
                            "vertical_max_m", "vertical_rms_m", "thread_seconds"}) {
      EXPECT_TRUE(level.contains(key)) << key;
    }
    EXPECT_LE(level.at("vertical_max_m").get<double>(), level.at("bound_m").get<double>());
    EXPECT_LE(level.at("vertical_rms_m").get<double>(), level.at("vertical_max_m").get<double>());
    tiles += level.at("tiles").get<std::uint64_t>();
  }
  EXPECT_EQ(found.at("levels")[0].at("bound_m"), 8);
  EXPECT_EQ(found.at("tiles"), tiles);
  EXPECT_EQ(found.at("tiles_made"), tiles);
  EXPECT_EQ(tiles, 1U + 4 + 9);
  const auto store = cache::TileStore::open(tree_);
  ASSERT_TRUE(store.has_value()) << store.error().text();
  EXPECT_EQ(store->bounds().nodes().size(), tiles);
}

TEST_F(BuildTest, TakesHalfTheSpacingForItsError) {
  digest();
  EXPECT_EQ(json::parse(read_file(report_)).at("error_m"), 5);
}

TEST_F(BuildTest, GivesTheSameTreeWithOneThreadAndTwo) {
  const std::string one = digest({"--threads", "1"});
  EXPECT_EQ(one.size(), 32U);
  EXPECT_EQ(digest({"--threads", "2", "--overwrite"}), one);
  EXPECT_NE(digest({"--error", "1", "--overwrite"}), one);
}

// Of two levels a doubling, every second one is a level of a tree with one, bit for bit.
TEST_F(BuildTest, PutsALevelBetweenEachTwo) {
  for (const char* method : {"tin", "strip", "scalar"}) {
    SCOPED_TRACE(method);
    ASSERT_NE(digest({"--error", "2", "--method", method, "--overwrite"}), "");
    fs::rename(tree_, dir_.file("one.tintree"));
    const std::string whole = digest({"--error", "2", "--method", method, "--levels-per-doubling", "2"});
    EXPECT_EQ(
        digest({"--error", "2", "--method", method, "--levels-per-doubling", "2", "--threads", "1", "--overwrite"}),
        whole);
    const auto one = cache::TileStore::open(dir_.file("one.tintree"));
    const auto two = cache::TileStore::open(tree_);
    ASSERT_TRUE(one.has_value() && two.has_value());
    EXPECT_EQ(two->manifest().layout.leaf_level, 4);
    EXPECT_EQ(two->bounds().nodes().size(), 1U + 4 + 4 + 9 + 9);
    for (const cache::TileNode& node : one->bounds().nodes()) {
      const auto a = one->read(node.id);
      const auto b = two->read({2 * node.id.level, node.id.x, node.id.y});
      ASSERT_TRUE(a && b) << node.id.text();
      EXPECT_EQ(a->payload, b->payload) << node.id.text();
      EXPECT_EQ(a->info.error_m, b->info.error_m) << node.id.text();
    }
  }
}

TEST_F(BuildTest, MakesWaveletTilesByEitherCriterion) {
  const std::string max = digest({"--method", "wavelet", "--criterion", "max", "--tile", "16", "--threads", "1"});
  EXPECT_EQ(digest({"--method", "wavelet", "--criterion", "max", "--tile", "16", "--threads", "4", "--overwrite"}),
            max);
  digest({"--method", "wavelet", "--tile", "16", "--overwrite"});
  EXPECT_EQ(cache::TileStore::open(tree_)->manifest().criterion, "rms");
}

TEST_F(BuildTest, QuantizesAsAsked) {
  const std::string uniform = digest({"--method", "scalar", "--threads", "1"});
  EXPECT_EQ(digest({"--method", "scalar", "--quantizer", "uniform", "--threads", "2", "--overwrite"}), uniform);
  const ProgramResult r = build({"--method", "scalar", "--quantizer", "lloyd-max", "--resume"});
  EXPECT_EQ(r.exit_code, kUsage) << r.all();
  expect_message(r, {"--quantizer", "uniform there", "lloyd-max here"});
  EXPECT_NE(digest({"--method", "scalar", "--quantizer", "lloyd-max", "--overwrite"}), uniform);
}

TEST_F(BuildTest, TakesIntegersHolesAndOddSizes) {
  write_raster(dem_, {.columns = 2, .rows = 2, .type = SampleType::kInt16}, [](int c, int r) { return c + r; });
  EXPECT_NE(digest(), "");
  write_raster(dem_, {.columns = 131, .rows = 3, .type = SampleType::kInt16},
               [](int c, int r) { return c % 17 == 5 && r == 1 ? kMissing : hills(c, r); });
  EXPECT_NE(digest({"--overwrite"}), "");
}

TEST_F(BuildTest, IsQuietWhenAsked) {
  const ProgramResult r = build();
  EXPECT_EQ(r.exit_code, kDone);
  EXPECT_EQ(r.all(), "");
}

TEST_F(BuildTest, WarnsOfAMissingGeoreference) {
  write_raster(dem_, {.columns = 40, .rows = 40, .epsg = 0}, [](int c, int r) { return hills(c, r); });
  const ProgramResult r = run_program(TINTREE_BUILD, {dem_, "-o", tree_});
  EXPECT_EQ(r.exit_code, kDone) << r.all();
  EXPECT_NE(r.err.find("warning: no georeference"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find(dem_), std::string::npos) << r.err;
}

// The build foretells which strips the viewer's caching thread makes meshes of.
TEST_F(BuildTest, WarnsOfStripsThatNoCardUnpacks) {
  const Words options{dem_, "-o", tree_, "--tile", "32", "--method", "strip", "--overwrite"};
  const auto with = [&](Words more) {
    more.insert(more.begin(), options.begin(), options.end());
    const ProgramResult r = run_program(TINTREE_BUILD, more);
    EXPECT_EQ(r.exit_code, kDone) << r.all();
    return r.err;
  };
  EXPECT_EQ(with({}).find("drawn as meshes"), std::string::npos);
  write_raster(dem_, {.columns = 90, .rows = 70, .dx = 10, .dy = 10},
               [](int c, int r) { return hills(c, r) + (c > 70 ? 8000 : 0); });
  for (const char* effort : {"fast", "best"}) {
    const std::string said = with({"--error", "0.01", "--effort", effort});
    const auto store = cache::TileStore::open(tree_);
    ASSERT_TRUE(store.has_value());
    std::size_t meshes = 0;
    const std::size_t tiles = store->bounds().nodes().size();
    for (const cache::TileNode& node : store->bounds().nodes()) {
      const auto packed = codec::packed_strip(store->read(node.id)->payload);
      const auto mesh = store->read_mesh(node.id);
      ASSERT_TRUE(packed && mesh);
      meshes += cache::make_drawable_strip(store->manifest().layout, node.id, *packed, *mesh, 0) == nullptr ? 1 : 0;
    }
    EXPECT_GT(meshes, 0U);
    EXPECT_LT(meshes, tiles);
    EXPECT_NE(said.find(tree_ + ": warning: " + std::to_string(meshes) + " of " + std::to_string(tiles) + " tiles are"),
              std::string::npos)
        << said;
    Words again = options;
    again.back() = "--resume";
    again.insert(again.end(), {"--error", "0.01", "--effort", effort});
    EXPECT_NE(run_program(TINTREE_BUILD, again).err.find(std::to_string(meshes) + " of "), std::string::npos);
  }
}

TEST_F(BuildTest, RefusesADemThatIsNotThere) {
  fs::remove(dem_);
  expect_refused({}, kIo, {dem_, "no such file"});
}

TEST_F(BuildTest, RefusesAFileThatIsNoRaster) {
  write_file(dem_, "these are words, and no heights\n");
  expect_refused({}, kBadData, {dem_, "no raster"});
  write_file(dem_, "");
  expect_refused({}, kBadData, {dem_});
}

TEST_F(BuildTest, RefusesATruncatedRaster) {
  const std::string whole = read_file(dem_);
  write_file(dem_, whole.substr(0, whole.size() / 3));
  const ProgramResult r = build();
  EXPECT_TRUE(r.exit_code == kBadData || r.exit_code == kIo) << r.all();
  expect_message(r, {dem_});
  EXPECT_FALSE(fs::exists(tree_));
}

TEST_F(BuildTest, RefusesOneRow) {
  write_raster(dem_, {.columns = 40, .rows = 1}, [](int c, int) { return c; });
  expect_refused({}, kBadData, {dem_, "40 x 1"});
}

TEST_F(BuildTest, RefusesARasterOfNodata) {
  write_raster(dem_, {.columns = 40, .rows = 40}, [](int, int) { return kMissing; });
  expect_refused({}, kBadData, {dem_, "nodata"});
}

TEST_F(BuildTest, RefusesARasterWithoutAnySurface) {
  // Samples, but no three that make a triangle.
  write_raster(dem_, {.columns = 40, .rows = 40}, [](int c, int r) { return c % 2 == 0 && r % 2 == 0 ? 1 : kMissing; });
  const ProgramResult r = build();
  EXPECT_EQ(r.exit_code, kBadData) << r.all();
  expect_message(r, {dem_});
  EXPECT_FALSE(fs::exists(tree_));
}

TEST_F(BuildTest, RefusesUndeclaredNodataBeyondTheFormat) {
  write_raster(dem_, {.columns = 40, .rows = 40, .type = SampleType::kFloat32, .nodata = {}},
               [](int c, int r) { return c < 5 ? -3.4e38 : hills(c, r); });
  expect_refused({}, kBadData, {dem_, "nodata"});
}

TEST_F(BuildTest, LeavesAnExistingOutputAlone) {
  write_file(tree_, "precious");
  const ProgramResult r = build();
  EXPECT_EQ(r.exit_code, kIo) << r.all();
  expect_message(r, {tree_, "--overwrite"});
  EXPECT_EQ(read_file(tree_), "precious");
  EXPECT_NE(digest({"--overwrite"}), "");
}

TEST_F(BuildTest, KeepsTheOldTreeWhenAnOverwritingBuildFails) {
  write_file(tree_, "precious");
  write_file(dem_, "no heights");
  EXPECT_EQ(build({"--overwrite"}).exit_code, kBadData);
  EXPECT_EQ(read_file(tree_), "precious");
}

TEST_F(BuildTest, RefusesAnOutputInAMissingFolder) {
  tree_ = dir_.file("nowhere/t.tintree");
  expect_refused({}, kIo, {dir_.file("nowhere")});
}

TEST_F(BuildTest, RefusesADirectoryAsOutput) {
  fs::create_directory(tree_);
  const ProgramResult r = build({"--overwrite"});
  EXPECT_EQ(r.exit_code, kIo) << r.all();
  expect_message(r, {tree_, "directory"});
  EXPECT_TRUE(fs::is_directory(tree_));
}

TEST_F(BuildTest, RefusesAFolderThatMayNotBeWrittenTo) {
  const std::string setpriv = "/usr/bin/setpriv";
  if (geteuid() == 0 && !fs::exists(setpriv)) GTEST_SKIP() << "root writes everywhere, and there is no setpriv";
  fs::permissions(dir_.path(),
                  fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read | fs::perms::others_exec);
  fs::permissions(dem_, fs::perms::all);
  const std::string script =
      geteuid() == 0 ? "exec " + setpriv + " --reuid=65534 --clear-groups -- \"$@\"" : "exec \"$@\"";
  const ProgramResult r = build_under(script);
  if (r.exit_code == 126 || r.exit_code == 127) GTEST_SKIP() << "the program cannot be run as another user: " << r.err;
  EXPECT_EQ(r.exit_code, kIo) << r.all();
  expect_message(r, {dir_.path(), "permission"});
  EXPECT_FALSE(fs::exists(tree_));
}

TEST_F(BuildTest, RefusesWrongOptions) {
  expect_refused({"--sideways"}, kUsage, {"--sideways"});
  expect_refused({"--tile", "100"}, kUsage, {"--tile", "power of two"});
  for (const char* tile : {"0", "-16", "4", "8192", "many"}) expect_refused({"--tile", tile}, kUsage, {"--tile"});
  for (const char* error : {"0", "-1", "nan", "inf", "-0", "large"})
    expect_refused({"--error", error}, kUsage, {"--error"});
  for (const char* threads : {"-1", "100000"}) expect_refused({"--threads", threads}, kUsage, {"--threads"});
  for (const char* memory : {"1", "0"}) expect_refused({"--memory", memory}, kUsage, {"--memory"});
  expect_refused({"--memory", "-5"}, kUsage, {"--memory"});
  expect_refused({"--method", "magic"}, kUsage, {"--method"});
  expect_refused({"--criterion", "max"}, kUsage, {"--criterion", "wavelet"});
  expect_refused({"--method", "wavelet", "--criterion", "mean"}, kUsage, {"--criterion"});
  for (const char* levels : {"0", "3", "some"})
    expect_refused({"--levels-per-doubling", levels}, kUsage, {"--levels-per-doubling"});
  for (const char* method : {"nested", "wavelet"})
    expect_refused({"--levels-per-doubling", "2", "--method", method}, kUsage, {"--levels-per-doubling", method});
  expect_refused({"--resume", "--overwrite"}, kUsage, {"--resume", "--overwrite"});
  expect_refused({"--method", "nested", "--effort", "best"}, kUsage, {"--effort", "tin and strip", "nested"});
  expect_refused({"--quantizer", "uniform"}, kUsage, {"--quantizer", "--method scalar"});
  expect_refused({"--method", "scalar", "--quantizer", "finest"}, kUsage, {"--quantizer"});
}

TEST_F(BuildTest, WantsADemAndAnOutput) {
  for (const Words& words : {Words{}, Words{dem_}, Words{"-o", tree_}}) {
    const ProgramResult r = run_program(TINTREE_BUILD, words);
    EXPECT_EQ(r.exit_code, kUsage);
    expect_message(r, {"required"});
  }
  EXPECT_EQ(run_program(TINTREE_BUILD, {"--help"}).exit_code, kDone);
  const ProgramResult version = run_program(TINTREE_BUILD, {"--version"});
  EXPECT_EQ(version.exit_code, kDone);
  EXPECT_TRUE(version.out.starts_with("tintree-build ")) << version.out;
}

TEST_F(BuildTest, RefusesAReportThatCannotBeWrittenBeforeAllWork) {
  expect_refused({"--json", dir_.file("no/such/report.json")}, kIo, {"report.json", "no folder", dir_.file("no/such")});
  expect_refused({"--json", dir_.path()}, kIo, {dir_.path(), "directory"});
}

TEST_F(BuildTest, WritesTheReportToAPipe) {
  const ProgramResult r = build_under("\"$@\" --json /dev/stdout | cat");
  EXPECT_EQ(r.exit_code, kDone) << r.all();
  EXPECT_EQ(json::parse(r.out).at("digest").get<std::string>().size(), 32U);
}

TEST_F(BuildTest, TakesSeveralDemsInOrder) {
  const std::string east = dir_.file("east.tif");
  write_raster(east, {.columns = 60, .rows = 70, .dx = 10, .dy = 10, .west = 1800},
               [](int c, int r) { return hills(c + 80, r) + 15; });
  digest({east});
  const auto store = cache::TileStore::open(tree_);
  ASSERT_TRUE(store.has_value());
  const cache::Manifest& m = store->manifest();
  EXPECT_EQ(m.layout.columns, 140);
  ASSERT_EQ(m.inputs.size(), 2U);
  EXPECT_EQ(m.inputs[0].path, dem_);
  EXPECT_EQ(m.inputs[1].path, east);
  EXPECT_EQ(m.inputs[1].bytes, fs::file_size(east));

  write_raster(east, {.columns = 60, .rows = 70, .dx = 10, .dy = 10, .west = 1805}, [](int, int) { return 1; });
  const ProgramResult r = build({east, "--overwrite"});
  EXPECT_EQ(r.exit_code, kBadData) << r.all();
  expect_message(r, {east, dem_, "gdalwarp"});
}

TEST_F(BuildTest, ResumesWithTheSameDemsOnly) {
  const std::string other = dir_.file("other.tif");
  write_raster(other, {.columns = 60, .rows = 50, .dx = 10, .dy = 10, .west = 1200},
               [](int c, int r) { return hills(c, r) + 15; });
  const std::string moved = dir_.file("moved.tif");
  fs::copy(other, moved);
  const std::string whole = digest({other});
  {
    // The same build before its first tile.
    cache::Manifest manifest = cache::TileStore::open(tree_)->manifest();
    manifest.complete = false;
    manifest.digest.clear();
    fs::remove(tree_);
    ASSERT_TRUE(cache::TileWriter::create(tree_, manifest).has_value());
  }
  ProgramResult r = build({"--resume"});
  EXPECT_EQ(r.exit_code, kUsage) << r.all();
  expect_message(r, {"number of input files", "--overwrite"});
  r = build({"--resume", dem_});
  EXPECT_EQ(r.exit_code, kUsage) << r.all();
  expect_message(r, {"input file 2", "other.tif"});
  r = build({"--resume", "--nodata", "fill", other});
  EXPECT_EQ(r.exit_code, kUsage) << r.all();
  expect_message(r, {"--nodata"});
  // The same heights, whatever the file's name.
  EXPECT_EQ(digest({"--resume", moved}), whole);
}

TEST_F(BuildTest, FillsHolesWhenAsked) {
  write_raster(dem_, {.columns = 60, .rows = 50},
               [](int c, int r) { return c > 20 && c < 30 && r > 9 ? kMissing : 7; });
  digest({"--nodata", "fill"});
  EXPECT_EQ(json::parse(read_file(report_)).at("valid_samples"), 60 * 50);
  digest({"--overwrite"});
  EXPECT_EQ(json::parse(read_file(report_)).at("valid_samples"), 60 * 50 - 9 * 40);
  EXPECT_EQ(build({"--overwrite", "--nodata", "water"}).exit_code, kUsage);

  write_raster(dem_, {.columns = 400, .rows = 10}, [](int c, int) { return c > 9 ? kMissing : 7; });
  const ProgramResult r = run_program(TINTREE_BUILD, {dem_, "-o", tree_, "--nodata", "fill", "--overwrite"});
  EXPECT_EQ(r.exit_code, kDone) << r.all();
  EXPECT_NE(r.err.find("samples stay holes"), std::string::npos) << r.err;
}

TEST_F(BuildTest, MakesTheSameTreeFromACopyOfTheHeights) {
  // Deflated rows of more bytes than GDAL may keep at so little memory.
  const auto write = [this](bool rows) {
    write_raster(dem_, {.columns = 1300, .rows = 1000, .tile = rows ? 0 : 256, .deflate = rows},
                 [](int c, int r) { return c > 900 && c < 930 ? kMissing : hills(c, r) + c * 0.1; });
  };
  const Words options{"--tile", "256", "--error", "20", "--threads", "1", "--memory", "208", "--overwrite"};
  write(false);
  const std::string direct = digest(options);
  write(true);
  EXPECT_EQ(digest(options), direct);
  const ProgramResult full = build_under("ulimit -f 4000; exec \"$@\"", options);
  EXPECT_EQ(full.exit_code, kIo) << full.all();
  expect_message(full, {dir_.path(), "temporary copy"});
}

}  // namespace
}  // namespace tintree::test
