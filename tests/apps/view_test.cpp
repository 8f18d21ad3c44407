#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cache/tile_store.h"
#include "tests/render/analytic_tree.h"
#include "tests/support/run_program.h"
#include "tests/support/temp_dir.h"

namespace tintree::view {
namespace {

constexpr const char* kFlight = R"({"keyframes": [
    {"seconds": 0, "eye_m": [640, -1500, 500], "target_m": [640, -640, 0]},
    {"seconds": 0.2, "eye_m": [640, -1100, 200], "azimuth_deg": 10, "elevation_deg": -20}]})";

/// The command line; TINTREE_VIEW is the program's path.
class ViewProgram : public testing::Test {
 protected:
  void SetUp() override { test::AnalyticTree().write(tree_); }

  test::ProgramResult view(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"-u", "DISPLAY", "-u", "WAYLAND_DISPLAY", TINTREE_VIEW});
    return test::run_program("/usr/bin/env", arguments);
  }

  /// One line of error, which names what it is about.
  static void expect_failure(const test::ProgramResult& r, int code, const std::string& about) {
    EXPECT_EQ(r.exit_code, code) << r.all();
    EXPECT_NE(r.err.find(about), std::string::npos) << r.err;
    EXPECT_EQ(std::ranges::count(r.err, '\n'), 1) << r.err;
  }

  std::string with_damaged(const codec::TileId& id) const;

  test::TempDir dir_;
  std::string tree_ = dir_.file("small.tintree");
};

TEST_F(ViewProgram, WritesAPictureAndItsFigures) {
  const std::string png = dir_.file("picture.png");
  const std::string json = dir_.file("figures.json");
  const auto r = view({tree_, "--headless", "osmesa", "--screenshot", png, "--size", "200x100", "--json", json});
  ASSERT_EQ(r.exit_code, 0) << r.all();
  EXPECT_EQ(test::read_file(png).substr(1, 3), "PNG");
  const auto figures = nlohmann::json::parse(test::read_file(json));
  EXPECT_EQ(figures.at("width_px"), 200);
  EXPECT_GT(figures.at("triangles").get<int>(), 100);
  EXPECT_GE(figures.at("tiles").get<int>(), 1);
  EXPECT_GT(figures.at("seconds").get<double>(), 0);
  EXPECT_LE(figures.at("max_error_px").get<double>(), 1);
  EXPECT_FALSE(std::filesystem::exists(png + ".tmp"));
}

TEST_F(ViewProgram, MorphsAndFogs) {
  const std::vector<std::string> plain{tree_,     "--headless",    "osmesa", "--size",
                                       "200x100", "--pixel-error", "4",      "--quiet"};
  const auto shot = [&](std::vector<std::string> extra) {
    const std::string png = dir_.file("shot.png");
    extra.insert(extra.begin(), plain.begin(), plain.end());
    extra.insert(extra.end(), {"--screenshot", png});
    const auto r = view(extra);
    EXPECT_EQ(r.exit_code, 0) << r.all();
    return test::read_file(png);
  };
  const std::string still = shot({});
  EXPECT_NE(shot({"--fog", "500"}), still);
  EXPECT_FALSE(shot({"--morph"}).empty());
  expect_failure(view({tree_, "--headless", "osmesa", "--fog", "-1"}), 2, "--fog");
}

TEST_F(ViewProgram, DrawsThroughEglWhereThereIsOne) {
  const auto egl = view({tree_, "--headless", "egl", "--screenshot", dir_.file("b.png"), "--quiet"});
  if (egl.exit_code == 4) GTEST_SKIP() << egl.err;
  ASSERT_EQ(egl.exit_code, 0) << egl.all();
  EXPECT_TRUE(std::filesystem::exists(dir_.file("b.png")));
}

TEST_F(ViewProgram, TakesAnEyeAndATarget) {
  const std::string json = dir_.file("figures.json");
  const auto r = view({tree_, "--headless", "osmesa", "--eye", "-100.5,-2000,900", "--target", "640,-640,0",
                       "--pixel-error", "0", "--json", json, "--quiet"});
  ASSERT_EQ(r.exit_code, 0) << r.all();
  EXPECT_EQ(r.all(), "");
  const auto figures = nlohmann::json::parse(test::read_file(json));
  EXPECT_EQ(figures.at("eye_m"), nlohmann::json({-100.5, -2000.0, 900.0}));
  EXPECT_EQ(figures.at("target_m"), nlohmann::json({640.0, -640.0, 0.0}));
  EXPECT_EQ(figures.at("tiles"), 16);
}

TEST_F(ViewProgram, SaysWhatIsWrongWithTheCommandLine) {
  const std::vector<std::string> base{tree_, "--headless", "osmesa"};
  for (const auto& [option, value] : std::vector<std::pair<std::string, std::string>>{{"--size", "0x5"},
                                                                                      {"--size", "640"},
                                                                                      {"--size", "640x480x2"},
                                                                                      {"--size", "axb"},
                                                                                      {"--size", "99999x10"},
                                                                                      {"--eye", "1,2"},
                                                                                      {"--eye", "1,2,x"},
                                                                                      {"--target", "1,2,3,4"},
                                                                                      {"--target", "nan,0,0"},
                                                                                      {"--pixel-error", "-1"},
                                                                                      {"--pixel-error", "many"},
                                                                                      {"--gpu-memory", "0"},
                                                                                      {"--headless", "glx"}}) {
    std::vector<std::string> arguments = option == "--headless" ? std::vector<std::string>{tree_} : base;
    arguments.insert(arguments.end(), {option, value});
    expect_failure(view(arguments), 2, option);
  }
  expect_failure(view({tree_, "--no-such-option"}), 2, "--no-such-option");
  expect_failure(view({}), 2, "TREE");
  expect_failure(view({tree_, "--headless", "osmesa", "--eye", "1,2,3", "--target", "1,2,3"}), 2, "--eye");
}

TEST_F(ViewProgram, SaysWhatIsWrongWithTheFile) {
  expect_failure(view({dir_.file("none.tintree"), "--headless", "osmesa"}), 4, "none.tintree");
  expect_failure(view({dir_.path(), "--headless", "osmesa"}), 4, dir_.path());
  const std::string text = dir_.file("text.tintree");
  test::write_file(text, "this is no tree\n");
  const auto no_tree = view({text, "--headless", "osmesa"});
  expect_failure(no_tree, 3, "text.tintree");
  expect_failure(no_tree, 3, "tintree-build");
  const std::string cut = dir_.file("cut.tintree");
  const std::string whole = test::read_file(tree_);
  test::write_file(cut, whole.substr(0, whole.size() / 2 + 100));
  expect_failure(view({cut, "--headless", "osmesa"}), 3, "cut.tintree");
}

/// Flips one bit of a tile in a copy of the tree; returns the copy's path.
std::string ViewProgram::with_damaged(const codec::TileId& id) const {
  std::string bytes = test::read_file(tree_);
  const auto payload = cache::TileStore::open(tree_)->read(id)->payload;
  const std::size_t at =
      bytes.find(std::string(reinterpret_cast<const char*>(payload.data()) + payload.size() / 2, 60));
  EXPECT_NE(at, std::string::npos);
  bytes[at + 30] = static_cast<char>(bytes[at + 30] ^ 4);
  const std::string bad = dir_.file("bad.tintree");
  test::write_file(bad, bytes);
  return bad;
}

// Its parent stands in, the tile is named once, and the exit code tells that the picture is not what was asked for.
TEST_F(ViewProgram, DrawsADamagedTileFromItsParent) {
  const std::string png = dir_.file("bad.png");
  const std::string json = dir_.file("bad.json");
  const std::string bad = with_damaged({2, 1, 1});
  const auto r =
      view({bad, "--headless", "osmesa", "--pixel-error", "0", "--screenshot", png, "--json", json, "--quiet"});
  expect_failure(r, 3, "2/1/1");
  EXPECT_NE(r.err.find("bad.tintree"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(png));
  EXPECT_EQ(nlohmann::json::parse(test::read_file(json)).at("tiles"), 13);  // Three quadrants of leaves, and a parent.
  const std::string flight = dir_.file("flight.json");
  test::write_file(flight, kFlight);
  expect_failure(view({bad, "--headless", "osmesa", "--pixel-error", "0", "--flight", flight, "--frames",
                       dir_.file("f"), "--quiet", "--size", "64x48"}),
                 3, "2/1/1");
}

TEST_F(ViewProgram, GoesOnWithoutADamagedRoot) {
  const std::string png = dir_.file("bad.png");
  expect_failure(
      view({with_damaged({0, 0, 0}), "--headless", "osmesa", "--pixel-error", "1000", "--screenshot", png, "--quiet"}),
      3, "0/0/0");
  EXPECT_TRUE(std::filesystem::exists(png));
}

TEST_F(ViewProgram, SaysWhenGraphicsMemoryIsTooSmall) {
  test::AnalyticTree large;
  large.columns = large.rows = 257;
  large.tile_cells = 64;
  const std::string tree = dir_.file("large.tintree");
  large.write(tree);
  const std::string json = dir_.file("small_memory.json");
  const auto r =
      view({tree, "--headless", "osmesa", "--pixel-error", "0", "--gpu-memory", "1", "--json", json, "--quiet"});
  EXPECT_EQ(r.exit_code, 0) << r.all();
  EXPECT_NE(r.err.find("--gpu-memory"), std::string::npos) << r.err;
  EXPECT_GE(nlohmann::json::parse(test::read_file(json)).at("tiles"), 1);
  EXPECT_EQ(view({tree, "--headless", "osmesa", "--pixel-error", "0", "--quiet"}).err, "");
}

TEST_F(ViewProgram, FliesAndWritesFramesAndFigures) {
  const std::string flight = dir_.file("flight.json");
  test::write_file(flight, kFlight);
  std::vector<std::string> pictures;
  for (const char* folder : {"a", "b"}) {
    const std::string frames = dir_.file(folder);
    const std::string json = frames + ".json";
    const auto r = view({tree_, "--headless", "osmesa", "--flight", flight, "--fps", "10", "--frames", frames, "--size",
                         "160x120", "--json", json});
    ASSERT_EQ(r.exit_code, 0) << r.all();
    const auto figures = nlohmann::json::parse(test::read_file(json));
    EXPECT_EQ(figures.at("frame_count"), 3);
    EXPECT_EQ(figures.at("frames").size(), 3U);
    EXPECT_EQ(figures.at("late_frames"), 0);
    EXPECT_LE(figures.at("frame_seconds_median"), figures.at("frame_seconds_worst"));
    std::uint64_t triangles = 0, culled = 0, occluded = 0;
    for (const auto& f : figures.at("frames")) {
      EXPECT_GT(f.at("triangles").get<int>(), 100);
      EXPECT_EQ(f.at("late_tiles"), 0);
      EXPECT_EQ(f.at("tiles"), f.at("wanted_tiles"));
      culled += f.at("frustum_culled").get<std::uint64_t>();
      occluded += f.at("occluded").get<std::uint64_t>();
      triangles += f.at("triangles").get<std::uint64_t>();
    }
    EXPECT_EQ(figures.at("triangles"), triangles);
    EXPECT_EQ(figures.at("frustum_culled"), culled);
    EXPECT_EQ(figures.at("occluded"), occluded);
    EXPECT_FALSE(std::filesystem::exists(frames + "/frame-000003.png"));
    pictures.push_back(test::read_file(frames + "/frame-000002.png"));
  }
  EXPECT_EQ(pictures[0].substr(1, 3), "PNG");
  EXPECT_EQ(pictures[0], pictures[1]);  // A fixed step, whatever the clock says.
}

TEST_F(ViewProgram, FliesByTheClockWithoutWaiting) {
  const std::string flight = dir_.file("flight.json");
  const std::string json = dir_.file("flight_figures.json");
  test::write_file(flight, kFlight);
  const auto r = view(
      {tree_, "--headless", "osmesa", "--flight", flight, "--real-time", "--size", "64x48", "--json", json, "--quiet"});
  ASSERT_EQ(r.exit_code, 0) << r.all();
  const auto figures = nlohmann::json::parse(test::read_file(json));
  EXPECT_GE(figures.at("frame_count").get<int>(), 1);
  EXPECT_LE(figures.at("frame_count").get<int>(), 7);
  EXPECT_EQ(figures.at("waits_for_tiles"), false);
}

TEST_F(ViewProgram, SaysWhatIsWrongWithTheFlight) {
  const std::string flight = dir_.file("flight.json");
  const std::vector<std::string> base{tree_, "--headless", "osmesa", "--flight", flight};
  expect_failure(view(base), 4, "flight.json");
  test::write_file(flight, "nonsense");
  expect_failure(view(base), 3, "flight.json");
  // Before the tree is looked at.
  expect_failure(view({dir_.file("none.tintree"), "--headless", "osmesa", "--flight", flight}), 3, "flight.json");
  test::write_file(flight, R"({"keyframes": [{"seconds": 1e999}]})");
  expect_failure(view(base), 3, "number");
  test::write_file(flight, R"({"keyframes": [{"seconds": -1e308, "eye_m": [0, 0, 9], "target_m": [1, 1, 0]},
                                             {"seconds": 1e308, "eye_m": [0, 0, 9], "target_m": [1, 1, 0]}]})");
  expect_failure(view(base), 3, "seconds");
  test::write_file(flight, kFlight);
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), base.begin(), base.end());
    return view(more);
  };
  expect_failure(with({"--fps", "0"}), 2, "--fps");
  expect_failure(with({"--frames", dir_.file("f"), "--real-time"}), 2, "--frames");
  expect_failure(with({"--screenshot", dir_.file("f.png")}), 2, "--screenshot");
  expect_failure(with({"--frames", tree_}), 4, tree_);
  expect_failure(view({tree_, "--headless", "osmesa", "--frames", dir_.file("f")}), 2, "--frames");
}

TEST_F(ViewProgram, SaysThatOpenGlIsTooOld) {
  const auto r =
      test::run_program("/usr/bin/env", {"MESA_GL_VERSION_OVERRIDE=2.1", TINTREE_VIEW, tree_, "--headless", "osmesa"});
  expect_failure(r, 4, "OpenGL 3.3");
}

TEST_F(ViewProgram, WithoutADisplaySaysWhatToDo) { expect_failure(view({tree_}), 4, "--headless osmesa"); }

TEST_F(ViewProgram, SaysWhenThePictureCannotBeWritten) {
  const std::string png = dir_.file("no/such/folder.png");
  expect_failure(view({tree_, "--headless", "osmesa", "--screenshot", png}), 4, png);
  // Before the tree is looked at, and so before anything is drawn.
  const std::string none = dir_.file("none.tintree");
  expect_failure(view({none, "--headless", "osmesa", "--screenshot", png}), 4, png);
  expect_failure(view({none, "--headless", "osmesa", "--json", dir_.path()}), 4, dir_.path());
}

TEST_F(ViewProgram, NeverWritesOverWhatItReads) {
  const std::string flight = dir_.file("flight.json");
  test::write_file(flight, kFlight);
  const std::string whole = test::read_file(tree_);
  const std::string alias = dir_.file("./small.tintree");
  for (const char* option : {"--json", "--screenshot"})
    expect_failure(view({tree_, "--headless", "osmesa", option, alias}), 2, alias);
  expect_failure(view({tree_, "--headless", "osmesa", "--flight", flight, "--json", flight}), 2, "flight.json");
  EXPECT_EQ(test::read_file(tree_), whole);
  EXPECT_EQ(test::read_file(flight), kFlight);
}

}  // namespace
}  // namespace tintree::view
