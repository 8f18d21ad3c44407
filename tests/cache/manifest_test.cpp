#include "cache/manifest.h"

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tintree::cache {
namespace {

using nlohmann::json;

Manifest make_manifest() {
  Manifest m;
  m.layout.columns = 1000;
  m.layout.rows = 700;
  m.layout.tile_cells = 128;
  m.layout.leaf_level = 3;
  m.layout.dx_m = 30.1;
  m.layout.dy_m = 29.7;
  m.layout.leaf_error_m = 15;
  m.layout.z_step_m = {1, 0.5, 0.25, 0.125};
  m.crs_wkt = "GEOGCS[\"WGS 84\"]";
  m.geotransform = {-84.4, 0.001, 0, 36.7, 0, -0.001};
  m.geographic = true;
  m.height_unit_m = 0.3048;
  m.inputs = {{"/dems/a.tif", 123456789012, 1700000000}};
  m.samples_digest = "0123";
  m.complete = true;
  m.digest = "4567";
  return m;
}

TEST(Manifest, SurvivesItsJson) {
  std::mt19937 random(1);
  std::uniform_real_distribution<> positive(1e-12, 1e9);
  for (int i = 0; i < 200; ++i) {
    Manifest m = make_manifest();
    m.layout.dx_m = positive(random);
    m.layout.dy_m = positive(random);
    m.layout.leaf_error_m = positive(random);
    for (double& step : m.layout.z_step_m) step = positive(random);
    for (double& g : m.geotransform) g = positive(random) - 5e8;
    const auto back = Manifest::from_json(m.to_json());
    ASSERT_TRUE(back.has_value()) << back.error().text();
    EXPECT_EQ(back->to_json(), m.to_json());
    EXPECT_EQ(back->layout.dx_m, m.layout.dx_m);
    EXPECT_EQ(back->layout.z_step_m, m.layout.z_step_m);
    EXPECT_EQ(back->geotransform, m.geotransform);
    EXPECT_EQ(back->inputs, m.inputs);
    EXPECT_EQ(back->method, "tin");
    EXPECT_TRUE(back->complete && back->geographic);
  }
}

TEST(Manifest, TakesPathsThatAreNoUtf8) {
  Manifest m = make_manifest();
  m.inputs[0].path = "/dems/H\xf6hen.tif";
  const auto back = Manifest::from_json(m.to_json());
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->inputs[0].bytes, m.inputs[0].bytes);
}

TEST(Manifest, EveryKeyIsNeededAndTyped) {
  const json whole = json::parse(make_manifest().to_json());
  for (const auto& item : whole.items()) {
    json without = whole;
    without.erase(item.key());
    EXPECT_EQ(Manifest::from_json(without.dump()).has_value(), item.key() == "nodata") << "without " << item.key();
    json odd = whole;
    odd[item.key()] = json::object({{"what", nullptr}});
    EXPECT_FALSE(Manifest::from_json(odd.dump()).has_value()) << "odd " << item.key();
    json null = whole;
    null[item.key()] = nullptr;
    EXPECT_FALSE(Manifest::from_json(null.dump()).has_value()) << "null " << item.key();
  }
}

TEST(Manifest, LacksAxesAndNodataInOldFiles) {
  Manifest m = make_manifest();
  m.nodata = NodataPolicy::kFill;
  m.layout.axes = {{0.6, 0.8}, {0.8, -0.6}};
  const auto back = Manifest::from_json(m.to_json());
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->nodata, NodataPolicy::kFill);
  EXPECT_EQ(back->layout.axes, m.layout.axes);
  json old = json::parse(m.to_json());
  for (const char* key : {"nodata", "column_axis", "row_axis"}) old.erase(key);
  const auto plain = Manifest::from_json(old.dump());
  ASSERT_TRUE(plain.has_value()) << plain.error().text();
  EXPECT_EQ(plain->nodata, NodataPolicy::kHole);
  EXPECT_EQ(plain->layout.axes, codec::GridAxes{});
}

TEST(Manifest, UnknownKeysAreIgnored) {
  json j = json::parse(make_manifest().to_json());
  j["colour"] = "green";
  EXPECT_TRUE(Manifest::from_json(j.dump()).has_value());
}

TEST(Manifest, ImpossibleTreesAreRefused) {
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<std::function<void(codec::TreeLayout&)>> damages = {
      [](auto& l) { l.columns = 1; },
      [](auto& l) { l.rows = -5; },
      [](auto& l) { l.columns = (std::int64_t{1} << 40) + 1; },
      [](auto& l) { l.tile_cells = 0; },
      [](auto& l) { l.tile_cells = 100; },
      [](auto& l) { l.tile_cells = 1 << 17; },
      [](auto& l) { l.leaf_level = -1; },
      [](auto& l) { l.leaf_level = 2; },
      [](auto& l) { l.leaf_level = 4; },
      [](auto& l) { l.leaf_level = 1 << 30; },
      [](auto& l) { l.levels_per_doubling = 0; },
      [](auto& l) { l.levels_per_doubling = 2; },
      [](auto& l) {
        l.levels_per_doubling = 3;
        l.leaf_level = 9;
        l.z_step_m.resize(10, 1);
      },
      [](auto& l) { l.z_step_m.pop_back(); },
      [](auto& l) { l.z_step_m[1] = 0; },
      [](auto& l) { l.z_step_m[2] = -1; },
      [](auto& l) { l.dx_m = 0; },
      [](auto& l) { l.dy_m = -3; },
      [inf](auto& l) { l.dx_m = inf; },
      [](auto& l) {
        l.axes.column = {2, 0};
      },
      [](auto& l) {
        l.axes.row = {1, 0};
      },
      [](auto& l) {
        l.axes.row = {0, 1};
      },
      [](auto& l) { l.leaf_error_m = 0; },
      [](auto& l) { l.leaf_error_m = std::nan(""); },
  };
  for (std::size_t i = 0; i < damages.size(); ++i) {
    Manifest m = make_manifest();
    damages[i](m.layout);
    const auto back = Manifest::from_json(m.to_json());
    ASSERT_FALSE(back.has_value()) << "damage " << i;
    EXPECT_EQ(back.error().code, ErrorCode::kBadData);
  }
}

TEST(Manifest, TwoLevelsADoublingAreForMethodsThatCan) {
  Manifest m = make_manifest();
  m.layout.levels_per_doubling = 2;
  m.layout.leaf_level = 6;
  m.layout.z_step_m.resize(7, 1);
  const auto back = Manifest::from_json(m.to_json());
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->layout.levels_per_doubling, 2);
  for (const char* method : {"nested", "wavelet"}) {
    m.method = method;
    EXPECT_FALSE(Manifest::from_json(m.to_json()).has_value()) << method;
  }
}

TEST(Manifest, TexturesOnSquaresInLeaves) {
  Manifest m = make_manifest();
  m.texture_size = 256;
  m.texture_codec = "bc1";
  EXPECT_EQ(m.to_json().find("texture_depth"), std::string::npos);
  EXPECT_EQ(Manifest::from_json(m.to_json())->texture_depth, 0);
  m.texture_depth = 3;
  const auto back = Manifest::from_json(m.to_json());
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->texture_depth, 3);
  EXPECT_NE(m.difference(make_manifest()), "");
  const codec::TreeLayout squares = back->picture_layout(PictureKind::kTexture);
  EXPECT_EQ(squares.leaf_level, m.layout.leaf_level + 3);
  EXPECT_EQ(squares.cells_across(squares.leaf_level), m.layout.tile_cells / 8);
  for (int level = 0; level <= m.layout.leaf_level; ++level)
    EXPECT_EQ(squares.cells_across(level), m.layout.cells_across(level));
  EXPECT_EQ(back->picture_layout(PictureKind::kNormal).leaf_level, m.layout.leaf_level);
  for (const int impossible : {-1, kMostTextureDepth + 1, 1 << 30}) {
    json j = json::parse(back->to_json());
    j["texture_depth"] = impossible;
    EXPECT_FALSE(Manifest::from_json(j.dump()).has_value()) << impossible;
  }
}

TEST(Manifest, DamagedTextNeverCrashes) {
  std::mt19937 random(5);
  const std::string text = make_manifest().to_json();
  for (int i = 0; i < 5000; ++i) {
    std::string damaged = text;
    damaged[random() % damaged.size()] = static_cast<char>(random());
    if (i % 4 == 0) damaged.resize(random() % damaged.size());
    (void)Manifest::from_json(damaged);
  }
  for (const char* odd : {"", "null", "[]", "{}", "3", "{\"method\":\"tin\"}"})
    EXPECT_FALSE(Manifest::from_json(odd).has_value());
}

TEST(Manifest, DifferenceNamesTheOption) {
  const Manifest m = make_manifest();
  EXPECT_EQ(m.difference(m), "");
  const std::vector<std::pair<std::string, std::function<void(Manifest&)>>> changes = {
      {"--method", [](Manifest& o) { o.method = "strip"; }},
      {"--tile", [](Manifest& o) { o.layout.tile_cells = 256; }},
      {"--levels-per-doubling: 1 there, 2 here", [](Manifest& o) { o.layout.levels_per_doubling = 2; }},
      {"--error", [](Manifest& o) { o.layout.leaf_error_m = 7; }},
      {"columns", [](Manifest& o) { o.layout.columns = 1001; }},
      {"rows", [](Manifest& o) { o.layout.rows = 701; }},
      {"east-west", [](Manifest& o) { o.layout.dx_m = 31; }},
      {"north-south", [](Manifest& o) { o.layout.dy_m = 31; }},
      {"height step", [](Manifest& o) { o.layout.z_step_m[3] = 0.0625; }},
      {"height unit", [](Manifest& o) { o.height_unit_m = 1; }},
      {"direction",
       [](Manifest& o) {
         o.layout.axes = {{0, -1}, {-1, 0}};
       }},
      {"--nodata", [](Manifest& o) { o.nodata = NodataPolicy::kFill; }},
      {"same size and time", [](Manifest& o) { o.samples_digest = "ffff"; }},
      {"/dems/a.tif: 123456789012 bytes there, 5 here",
       [](Manifest& o) {
         o.samples_digest = "ffff";
         o.inputs[0].bytes = 5;
       }},
      {"/dems/a.tif, which was modified at 2023-11-14 22:13:20 UTC there, at 2023-11-14 22:13:21 here",
       [](Manifest& o) {
         o.samples_digest = "ffff";
         ++o.inputs[0].modified_s;
       }},
      {"number of input files: 1 there, 2 here",
       [](Manifest& o) {
         o.samples_digest = "ffff";
         o.layout.columns = 22;
         o.inputs.push_back({});
       }},
      {"input file 1: \"a.tif\" there, \"b.tif\" here",
       [](Manifest& o) {
         o.samples_digest = "ffff";
         o.inputs[0].path = "/dems/b.tif";
       }},
      {"coordinate reference system", [](Manifest& o) { o.crs_wkt = "LOCAL_CS[]"; }},
      {"coordinate reference system", [](Manifest& o) { o.geographic = false; }},
      {"georeference", [](Manifest& o) { o.geotransform[3] += 1; }},
  };
  for (const auto& [word, change] : changes) {
    Manifest other = m;
    change(other);
    EXPECT_NE(m.difference(other).find(word), std::string::npos) << word << ": " << m.difference(other);
  }
  Manifest moved = m;
  moved.inputs = {{"/elsewhere/a.tif", 1, 1}};
  moved.complete = false;
  moved.digest.clear();
  EXPECT_EQ(m.difference(moved), "");
}

}  // namespace
}  // namespace tintree::cache
