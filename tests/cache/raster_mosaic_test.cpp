/// Several DEMs as one RasterSource, and the copy that stage() makes.

#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "cache/raster_source.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::cache {
namespace {

using test::HeightFunction;
using test::HeightGrid;
using test::kMissing;
using test::RasterSpec;
using test::SampleType;

class RasterMosaicTest : public testing::Test {
 protected:
  std::string write(const std::string& name, const RasterSpec& spec, const HeightFunction& height) const {
    test::write_raster(dir_.file(name), spec, height);
    return dir_.file(name);
  }

  static RasterSource open(const std::vector<std::string>& paths) {
    auto source = RasterSource::open(paths);
    if (!source) throw std::runtime_error(source.error().text());
    return std::move(*source);
  }

  /// A file of `columns` x `rows` samples whose first one is sample (column, row) of the common grid.
  std::string part(const std::string& name, int column, int row, int columns, int rows, const HeightFunction& height,
                   RasterSpec spec = {}) const {
    spec.columns = columns;
    spec.rows = rows;
    spec.dx = 10;
    spec.dy = 20;
    spec.west = 1000 + 10.0 * column;
    spec.north = 2000 - 20.0 * row;
    return write(name, spec, [&](int c, int r) { return height(c + column, r + row); });
  }

  test::TempDir dir_;
};

void expect_equal(const HeightGrid& a, const HeightGrid& b) {
  ASSERT_EQ(a.columns, b.columns);
  ASSERT_EQ(a.rows, b.rows);
  for (std::size_t i = 0; i < a.heights_m.size(); ++i) {
    const double x = a.heights_m[i];
    const double y = b.heights_m[i];
    ASSERT_TRUE(x == y || (std::isnan(x) && std::isnan(y))) << i << ": " << x << " and " << y;
  }
}

TEST_F(RasterMosaicTest, LaterFilesLieOnTopAndLetTheOthersShowThroughHoles) {
  const std::string a = part("a.tif", 0, 3, 10, 8, [](int, int) { return 1.0; });
  const std::string b = part("b.tif", 6, 0, 9, 7, [](int c, int) { return c == 8 ? kMissing : 2.0; },
                             {.type = SampleType::kInt16, .nodata = -1});
  const auto expected = [](int c, int r, bool b_on_top) {
    const bool in_a = c < 10 && r >= 3;
    const bool in_b = c >= 6 && r < 7 && c != 8;
    if (in_a && in_b) return b_on_top ? 2.0 : 1.0;
    return in_a ? 1.0 : in_b ? 2.0 : kMissing;
  };
  for (const bool b_on_top : {true, false}) {
    const RasterSource source = open(b_on_top ? std::vector{a, b} : std::vector{b, a});
    const RasterInfo& info = source.info();
    EXPECT_EQ(info.columns, 15);
    EXPECT_EQ(info.rows, 11);
    EXPECT_EQ(info.geotransform, (GeoTransform{1000, 10, 0, 2000, 0, -20}));
    ASSERT_EQ(info.inputs.size(), 2U);
    EXPECT_EQ(info.inputs[0].path, b_on_top ? a : b);
    EXPECT_EQ(info.inputs[1].bytes, std::filesystem::file_size(b_on_top ? b : a));
    EXPECT_EQ(info.path, info.inputs[0].path + " and 1 more");
    const HeightGrid grid = test::read_grid(source);
    for (int r = 0; r < 11; ++r) {
      for (int c = 0; c < 15; ++c) {
        const double found = grid.at(c, r);
        const double truth = expected(c, r, b_on_top);
        EXPECT_TRUE(found == truth || (std::isnan(found) && std::isnan(truth))) << c << ", " << r << ": " << found;
      }
    }
  }
}

TEST_F(RasterMosaicTest, AStripOfOneSampleJoinsItsNeighbours) {
  const HeightFunction height = [](int c, int r) { return c + 100.0 * r; };
  const std::string a = part("a.tif", 0, 0, 4, 5, height);
  const std::string b = part("b.tif", 4, 0, 1, 5, height);
  const auto alone = RasterSource::open(b);
  ASSERT_FALSE(alone.has_value());
  EXPECT_EQ(alone.error().code, ErrorCode::kBadData);
  EXPECT_NE(alone.error().text().find("1 x 5"), std::string::npos);
  const HeightGrid grid = test::read_grid(open({a, b}));
  EXPECT_EQ(grid.columns, 5);
  EXPECT_EQ(grid.at(4, 3), 304);
}

TEST_F(RasterMosaicTest, MoreFilesThanStayOpen) {
  std::vector<std::string> paths;
  for (int i = 0; i < 150; ++i) {
    paths.push_back(part(std::to_string(i) + ".tif", 3 * i, 0, 3, 2, [](int c, int r) { return c + 1000.0 * r; }));
  }
  const RasterSource source = open(paths);
  for (int round = 0; round < 2; ++round) {
    const HeightGrid grid = test::read_grid(source);
    for (int c = 0; c < 450; ++c) ASSERT_EQ(grid.at(c, 1), c + 1000);
  }
}

TEST_F(RasterMosaicTest, EveryWarningIsGivenOnce) {
  const HeightFunction flat = [](int, int) { return 1.0; };
  const RasterSource source =
      open({part("a.tif", 0, 0, 3, 3, flat, {.epsg = 2225}), part("b.tif", 3, 0, 3, 3, flat, {.epsg = 2225})});
  ASSERT_EQ(source.info().warnings.size(), 1U) << "both lack a height unit";
  EXPECT_NE(source.info().warnings[0].find("a.tif"), std::string::npos);
}

TEST_F(RasterMosaicTest, FilesOnDifferentGridsAreRefused) {
  const HeightFunction flat = [](int, int) { return 1.0; };
  const std::string a = part("a.tif", 0, 0, 6, 6, flat);
  const std::vector<std::pair<RasterSpec, std::vector<std::string>>> others = {
      {{.dx = 10, .dy = 20, .epsg = 32611}, {"gdalwarp -t_srs"}},
      {{.dx = 10, .dy = 10, .west = 1000}, {"0.5 times as far apart", "gdalwarp -tr"}},
      {{.dx = 10, .dy = 20, .west = 1005}, {"0.5 samples off"}},
      {{.dx = 10, .dy = 20, .west = 1000, .north = 2001}, {"0.05 samples off"}},
      {{.dx = 10.1, .dy = 20, .west = 1000}, {"1.01 times as far apart", "gdalwarp -tr"}},
      {{.epsg = 0}, {"georeference"}}};
  for (const auto& [spec, words] : others) {
    const std::string b = write("b.tif", spec, flat);
    const auto source = RasterSource::open(std::vector{a, b});
    ASSERT_FALSE(source.has_value()) << words[0];
    EXPECT_EQ(source.error().code, ErrorCode::kBadData);
    EXPECT_EQ(source.error().where, b);
    for (const std::string& word : words)
      EXPECT_NE(source.error().message.find(word), std::string::npos) << source.error().message;
    EXPECT_NE(source.error().message.find(a), std::string::npos) << source.error().message;
  }
  // The rounding of stated coordinates is no reason to refuse.
  EXPECT_TRUE(RasterSource::open(std::vector{a, write("c.tif", {.dx = 10.00001, .dy = 20, .west = 1060.1}, flat)}));
}

TEST_F(RasterMosaicTest, TheCopyIsExact) {
  for (const SampleType type : {SampleType::kInt16, SampleType::kFloat32, SampleType::kFloat64}) {
    const HeightFunction height = [type](int c, int r) {
      if ((c / 40 + r / 30) % 5 == 0) return kMissing;
      return type == SampleType::kInt16 ? std::round(900 * std::sin(c * 0.1 + r)) : test::hills(c, r) / 3;
    };
    const std::string a = write("a.tif", {.columns = 600, .rows = 400, .type = type}, height);
    RasterSource source = open({a});
    const HeightGrid before = test::read_grid(source);
    // Uncompressed rows: they are copied only when GDAL cannot keep them.
    ASSERT_TRUE(source.stage({.folder = dir_.path(), .raster_cache_bytes = std::uint64_t{1} << 30}).has_value());
    EXPECT_FALSE(source.is_copied());
    ASSERT_TRUE(source.stage({.folder = dir_.path(), .raster_cache_bytes = 1000}).has_value());
    ASSERT_TRUE(source.is_copied());
    std::filesystem::remove(a);
    expect_equal(test::read_grid(source), before);
    std::array<double, 12> beyond{};
    ASSERT_TRUE(source.read(-1, 398, 4, 3, beyond.data()).has_value());
    EXPECT_TRUE(std::isnan(beyond[0]) && std::isnan(beyond[9]));
    EXPECT_TRUE(beyond[1] == before.at(0, 398) || std::isnan(before.at(0, 398)));
  }
}

TEST_F(RasterMosaicTest, TilesThatWindowsReadWellAreNotCopied) {
  const std::string tiled = dir_.file("tiled.tif");
  test::write_raster(tiled, {.columns = 600, .rows = 400, .tile = 256}, [](int c, int r) { return c + r; });
  RasterSource source = open({tiled});
  ASSERT_TRUE(source.stage({.folder = dir_.path(), .raster_cache_bytes = 1000, .block_cache_bytes = 1000}).has_value());
  EXPECT_FALSE(source.is_copied());
}

TEST_F(RasterMosaicTest, FillLeavesHeightsAloneAndStopsAtItsReach) {
  const HeightFunction height = [](int c, int r) {
    if ((c > 20 && c < 30 && r > 10 && r < 22) || c >= 100) return kMissing;
    return test::hills(c, r) / 3;
  };
  const std::string a = write("a.tif", {.columns = 260, .rows = 40}, height);
  RasterSource source = open({a});
  const HeightGrid before = test::read_grid(source);
  ASSERT_TRUE(source.stage({.nodata = NodataPolicy::kFill, .folder = dir_.path()}).has_value());
  const HeightGrid after = test::read_grid(source);
  double low = 1e9;
  double high = -1e9;
  for (const double h : before.heights_m) {
    low = std::isnan(h) ? low : std::min(low, h);
    high = std::isnan(h) ? high : std::max(high, h);
  }
  for (int r = 0; r < 40; ++r) {
    for (int c = 0; c < 260; ++c) {
      const double h = after.at(c, r);
      if (!std::isnan(before.at(c, r))) {
        ASSERT_EQ(h, before.at(c, r)) << c << ", " << r;
      } else if (c < 190) {
        ASSERT_TRUE(h >= low - 1e-4 && h <= high + 1e-4) << c << ", " << r << ": " << h;
      } else if (c > 210) {
        ASSERT_TRUE(std::isnan(h)) << c << ", " << r << ": " << h;
      }
    }
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(dir_.path()), {}), 1) << "temporary files are left";
}

TEST_F(RasterMosaicTest, AStagingThatIsStoppedSaysSo) {
  const std::string a = write("a.tif", {.columns = 60, .rows = 40}, [](int c, int) { return c < 9 ? kMissing : 1.0; });
  for (const std::string step : {"copying rows", "filling holes"}) {
    RasterSource source = open({a});
    const auto staged = source.stage({.nodata = NodataPolicy::kFill,
                                      .folder = dir_.path(),
                                      .progress = [&step](const std::string& at, auto, auto) { return at != step; }});
    ASSERT_FALSE(staged.has_value()) << step;
    EXPECT_EQ(staged.error().code, ErrorCode::kStopped);
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(dir_.path()), {}), 1) << "temporary files are left";
}

}  // namespace
}  // namespace tintree::cache
