#include "cache/ortho_source.h"

#include <cmath>
#include <filesystem>
#include <optional>
#include <vector>

#include <gdal_priv.h>
#include <gdal_utils.h>
#include <gtest/gtest.h>

#include "tests/support/temp_dir.h"
#include "tests/support/test_photo.h"

namespace tintree::cache {
namespace {

using test::RasterSpec;

class OrthoSourceTest : public testing::Test {
 protected:
  /// A DEM of 41 x 31 samples, 10 m apart.
  OrthoSourceTest() { write_dem({.columns = 41, .rows = 31, .dx = 10, .dy = 10}); }

  void write_dem(const RasterSpec& spec) {
    test::write_raster(dem_path_, spec, [](int c, int r) { return test::hills(c, r); });
    dem_.emplace(RasterSource::open(dem_path_)->info());
  }
  Expected<OrthoSource> open() const { return OrthoSource::open({photo_}, *dem_); }
  void expect_refused(ErrorCode code, const std::string& word) const {
    const auto source = open();
    ASSERT_FALSE(source.has_value());
    EXPECT_EQ(source.error().code, code);
    EXPECT_EQ(source.error().where, photo_);
    EXPECT_NE(source.error().message.find(word), std::string::npos) << source.error().text();
  }

  test::TempDir dir_;
  std::string dem_path_ = dir_.file("dem.tif");
  std::string photo_ = dir_.file("photo.tif");
  std::optional<RasterInfo> dem_;
};

std::array<int, 4> texel(const ColorWindow& w, std::int64_t column, std::int64_t row) {
  const auto at = 4 * static_cast<std::size_t>((row - w.row0) * w.width + column - w.column0);
  return {w.rgba[at], w.rgba[at + 1], w.rgba[at + 2], w.rgba[at + 3]};
}

std::array<int, 4> ints(const std::array<std::uint8_t, 4>& v) { return {v[0], v[1], v[2], v[3]}; }

/// A photo on the DEM's own grid comes through untouched: pixel for sample.
TEST_F(OrthoSourceTest, OnTheSameGridIsThePhoto) {
  test::write_photo(photo_, {.columns = 41, .rows = 31, .dx = 10, .dy = 10}, false, test::meadow);
  const auto source = open();
  ASSERT_TRUE(source.has_value()) << source.error().text();
  EXPECT_NEAR(source->pixel_samples(), 1, 1e-6);
  const auto window = source->read(1, -3, -2, 50, 40);
  ASSERT_TRUE(window.has_value()) << window.error().text();
  for (int r = -2; r < 38; ++r) {
    for (int c = -3; c < 47; ++c) {
      const bool inside = c >= 0 && r >= 0 && c < 41 && r < 31;
      ASSERT_EQ(texel(*window, c, r), inside ? ints(test::meadow(c, r)) : (std::array<int, 4>{})) << c << " " << r;
    }
  }
}

/// A photo of half the spacing: every second node of the fine grid is a DEM sample, at the photo's pixel 2 c.
TEST_F(OrthoSourceTest, AFinerPhotoLiesRight) {
  test::write_photo(photo_, {.columns = 81, .rows = 61, .dx = 5, .dy = 5, .west = 1002.5, .north = 1997.5}, false,
                    test::meadow);
  const auto source = open();
  ASSERT_TRUE(source.has_value()) << source.error().text();
  EXPECT_NEAR(source->pixel_samples(), 0.5, 1e-6);
  const auto fine = source->read(0.5, 0, 0, 81, 61);
  ASSERT_TRUE(fine.has_value());
  for (int r = 0; r < 61; ++r) {
    for (int c = 0; c < 81; ++c) ASSERT_EQ(texel(*fine, c, r), ints(test::meadow(c, r))) << c << " " << r;
  }
}

/// How fine photos are in a part of the DEM: by those that reach into it.
TEST_F(OrthoSourceTest, KnowsTheFinestPhotoOfAPlace) {
  test::write_photo(photo_, {.columns = 41, .rows = 31, .dx = 10, .dy = 10}, false, test::meadow);
  // Columns 10 to 18 and rows 5 to 11 of the samples, counted from pixels' sides.
  const std::string fine = dir_.file("fine.tif");
  test::write_photo(fine, {.columns = 32, .rows = 24, .dx = 2.5, .dy = 2.5, .west = 1100, .north = 1950}, false,
                    test::meadow);
  const auto source = OrthoSource::open({photo_, fine}, *dem_);
  ASSERT_TRUE(source.has_value()) << source.error().text();
  EXPECT_NEAR(source->pixel_samples(), 0.25, 1e-6);
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 40; ++column) {
      const bool reached = column + 1 > 9.5 && column < 17.5 && row + 1 > 4.5 && row < 10.5;
      EXPECT_NEAR(source->pixel_samples_in({column, row, column + 1, row + 1}), reached ? 0.25 : 1, 1e-6)
          << column << ' ' << row;
    }
  }
  EXPECT_TRUE(std::isinf(source->pixel_samples_in({60, 60, 70, 70})));
}

/// Another CRS and spacing: against a place computed by GDAL's own coordinate transformation.
TEST_F(OrthoSourceTest, AnotherCrsLiesRight) {
  write_dem({.columns = 41, .rows = 31, .dx = 10, .dy = 10, .west = 500000, .north = 4649776, .epsg = 32610});
  // In degrees, half a degree of turn apart; its colours tell its own columns and rows.
  const double degree = 1.0 / 111000 * 6;
  const RasterSpec spec{
      .columns = 120, .rows = 90, .dx = degree, .dy = degree / 1.3, .west = -123.0005, .north = 42.0005, .epsg = 4326};
  test::write_photo(photo_, spec, false, [](int c, int r) {
    return std::array<std::uint8_t, 4>{static_cast<std::uint8_t>(2 * c), static_cast<std::uint8_t>(2 * r), 77, 255};
  });
  const auto source = open();
  ASSERT_TRUE(source.has_value()) << source.error().text();
  const auto window = source->read(1, 0, 0, 41, 31);
  ASSERT_TRUE(window.has_value());
  OGRSpatialReference from;
  OGRSpatialReference to;
  from.importFromEPSG(32610);
  to.importFromEPSG(4326);
  to.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> moved(OGRCreateCoordinateTransformation(&from, &to));
  int seen = 0;
  for (int r = 0; r < 31; ++r) {
    for (int c = 0; c < 41; ++c) {
      double x = 500000 + 10 * (c + 0.5);
      double y = 4649776 - 10 * (r + 0.5);
      ASSERT_TRUE(moved->Transform(1, &x, &y));
      const double column = (x - spec.west) / spec.dx - 0.5;
      const double row = (spec.north - y) / spec.dy - 0.5;
      if (column < 2 || row < 2 || column > 117 || row > 87) continue;
      const auto t = texel(*window, c, r);
      ASSERT_NEAR(t[0], 2 * column, 1.2) << c << " " << r;
      ASSERT_NEAR(t[1], 2 * row, 1.2) << c << " " << r;
      ASSERT_EQ(t[3], 255);
      ++seen;
    }
  }
  EXPECT_GT(seen, 600);
}

TEST_F(OrthoSourceTest, FollowsATurnedDem) {
  write_dem({.columns = 41, .rows = 31, .dx = 10, .dy = 10, .turn_rad = 0.5});
  test::write_photo(photo_, {.columns = 41, .rows = 31, .dx = 10, .dy = 10, .turn_rad = 0.5}, false, test::meadow);
  const auto source = open();
  ASSERT_TRUE(source.has_value()) << source.error().text();
  const auto window = source->read(1, 0, 0, 41, 31);
  ASSERT_TRUE(window.has_value());
  for (int r = 1; r < 30; ++r) {
    for (int c = 1; c < 40; ++c) {
      for (std::size_t k = 0; k < 4; ++k)
        ASSERT_NEAR(texel(*window, c, r)[k], test::meadow(c, r)[k], 1.5) << c << " " << r;
    }
  }
}

TEST_F(OrthoSourceTest, AlphaAndLaterPhotosDecide) {
  const RasterSpec spec{.columns = 41, .rows = 31, .dx = 10, .dy = 10};
  const std::string under = dir_.file("under.tif");
  test::write_photo(under, spec, false, [](int, int) { return std::array<std::uint8_t, 4>{10, 20, 30, 255}; });
  test::write_photo(photo_, spec, true, [](int c, int) {
    return std::array<std::uint8_t, 4>{200, 100, 50, static_cast<std::uint8_t>(c < 20 ? 255 : 0)};
  });
  const auto alone = open();
  ASSERT_TRUE(alone.has_value()) << alone.error().text();
  const auto one = alone->read(1, 0, 0, 41, 31);
  const auto both = OrthoSource::open({under, photo_}, *dem_)->read(1, 0, 0, 41, 31);
  ASSERT_TRUE(one.has_value() && both.has_value());
  for (int c = 0; c < 41; ++c) {
    EXPECT_EQ(texel(*one, c, 5)[3], c < 20 ? 255 : 0);
    EXPECT_EQ(texel(*both, c, 5), c < 20 ? (std::array{200, 100, 50, 255}) : (std::array{10, 20, 30, 255})) << c;
  }
}

/// One band of 8 bits on the DEM's own grid, for which `change` has been called before it was written.
template <typename Value, typename Change>
void write_band(const std::string& path, const char* driver, const RasterInfo& dem, const Value& value,
                const Change& change) {
  const int columns = static_cast<int>(dem.columns);
  const int rows = static_cast<int>(dem.rows);
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < columns * rows; ++i) pixels.push_back(static_cast<std::uint8_t>(value(i % columns, i / columns)));
  GDALDriverManager& drivers = *GetGDALDriverManager();
  const GDALDatasetUniquePtr memory(drivers.GetDriverByName("MEM")->Create("", columns, rows, 1, GDT_Byte, nullptr));
  GeoTransform place = dem.geotransform;
  memory->SetGeoTransform(place.data());
  memory->SetProjection(dem.crs_wkt.c_str());
  const CPLErr written = memory->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, columns, rows, pixels.data(), columns, rows,
                                                            GDT_Byte, 0, 0, nullptr);
  ASSERT_EQ(written, CE_None);
  change(*memory);
  const GDALDatasetUniquePtr copy(
      drivers.GetDriverByName(driver)->CreateCopy(path.c_str(), memory.get(), FALSE, nullptr, nullptr, nullptr));
  ASSERT_TRUE(copy) << CPLGetLastErrorMsg();
}

/// A colour table's own colours, with its transparent ones: memory, not only values, was wrong here once.
TEST_F(OrthoSourceTest, AColourTableGivesItsColours) {
  const auto entry = [](int i) { return std::array{i, 255 - i, (7 * i) % 256, i < 20 ? 0 : 255}; };
  const auto add_table = [&](GDALDataset& d) {
    GDALColorTable table;
    for (int i = 0; i < 256; ++i) {
      const auto e = entry(i);
      const GDALColorEntry color{static_cast<short>(e[0]), static_cast<short>(e[1]), static_cast<short>(e[2]),
                                 static_cast<short>(e[3])};
      table.SetColorEntry(i, &color);
    }
    d.GetRasterBand(1)->SetColorTable(&table);
  };
  // A TIFF's table has no alpha.
  write_band(
      photo_, "PNG", *dem_, [](int c, int r) { return c + 5 * r; }, add_table);
  for (const bool staged : {false, true}) {
    auto source = open();
    ASSERT_TRUE(source.has_value()) << source.error().text();
    const auto go_on = [](const std::string&, std::uint64_t, std::uint64_t) { return true; };
    ASSERT_TRUE(source->stage(dir_.path(), staged ? 1 : 1 << 20, go_on).has_value());
    const auto window = source->read(1, 0, 0, 41, 31);
    ASSERT_TRUE(window.has_value()) << window.error().text();
    for (int r = 0; r < 31; ++r) {
      for (int c = 0; c < 41; ++c) {
        const auto e = entry(c + 5 * r);
        ASSERT_EQ(texel(*window, c, r), e[3] > 0 ? e : (std::array<int, 4>{})) << c << " " << r;
      }
    }
  }
}

/// Nodata and a mask band cover as little as alpha does; one band is grey.
TEST_F(OrthoSourceTest, WhatIsMaskedOutIsNotCovered) {
  const auto value = [](int c, int r) { return c < 20 ? 0 : 10 + c + r; };
  const auto state_nodata = [](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(0); };
  const auto add_mask = [](GDALDataset& d) {
    ASSERT_EQ(d.CreateMaskBand(GMF_PER_DATASET), CE_None);
    std::vector<std::uint8_t> mask;
    for (int i = 0; i < 41 * 31; ++i) mask.push_back(i % 41 < 20 ? 0 : 255);
    ASSERT_EQ(d.GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Write, 0, 0, 41, 31, mask.data(), 41, 31, GDT_Byte, 0, 0,
                                                          nullptr),
              CE_None);
  };
  for (const bool by_mask : {false, true}) {
    write_band(photo_, "GTiff", *dem_, value, [&](GDALDataset& d) { by_mask ? add_mask(d) : state_nodata(d); });
    const auto source = open();
    ASSERT_TRUE(source.has_value()) << source.error().text();
    const auto window = source->read(1, 0, 0, 41, 31);
    ASSERT_TRUE(window.has_value()) << window.error().text();
    for (int r = 0; r < 31; ++r) {
      for (int c = 0; c < 41; ++c) {
        const int grey = 10 + c + r;
        ASSERT_EQ(texel(*window, c, r), c < 20 ? (std::array<int, 4>{}) : (std::array{grey, grey, grey, 255}))
            << c << " " << r << " by mask: " << by_mask;
      }
    }
  }
}

/// What ends too early is an error that names the photo, whatever the format: of a JPEG the rest would be grey.
TEST_F(OrthoSourceTest, ACutFileIsAnError) {
  const std::string whole = dir_.file("whole.tif");
  test::write_photo(whole, {.columns = 164, .rows = 124, .dx = 2.5, .dy = 2.5}, false, test::meadow);
  for (const char* driver : {"GTiff", "JPEG", "PNG"}) {
    photo_ = dir_.file(driver);
    GDALDatasetUniquePtr copy(GetGDALDriverManager()->GetDriverByName(driver)->CreateCopy(
        photo_.c_str(), GDALDatasetUniquePtr(GDALDataset::Open(whole.c_str())).get(), FALSE, nullptr, nullptr,
        nullptr));
    copy.reset();
    ASSERT_TRUE(open()->read(1, 0, 0, 41, 31).has_value()) << driver;
    std::filesystem::resize_file(photo_, std::filesystem::file_size(photo_) / 2);
    const auto source = open();
    ASSERT_TRUE(source.has_value()) << driver << source.error().text();
    const auto window = source->read(1, 0, 0, 41, 31);
    ASSERT_FALSE(window.has_value()) << driver;
    EXPECT_EQ(window.error().code, ErrorCode::kIo);
    EXPECT_EQ(window.error().where, photo_);
  }
}

TEST_F(OrthoSourceTest, StagedItReadsTheSame) {
  test::write_photo(photo_, {.columns = 60, .rows = 50, .dx = 7, .dy = 7}, false, test::meadow);
  auto source = open();
  ASSERT_TRUE(source.has_value());
  const auto before = source->read(1, 0, 0, 41, 31);
  const auto go_on = [](const std::string&, std::uint64_t, std::uint64_t) { return true; };
  auto staged = open();
  ASSERT_TRUE(staged->stage(dir_.path(), 1, go_on).has_value());
  const auto after = staged->read(1, 0, 0, 41, 31);
  ASSERT_TRUE(before.has_value() && after.has_value());
  EXPECT_EQ(before->rgba, after->rgba);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(dir_.path()), {}), 2) << "the copy has no name";
  const auto stop =
      staged->stage(dir_.path(), 1, [](const std::string&, std::uint64_t, std::uint64_t) { return false; });
  EXPECT_EQ(stop.error().code, ErrorCode::kStopped);
}

TEST_F(OrthoSourceTest, RefusesWhatCannotBeDraped) {
  expect_refused(ErrorCode::kIo, "no such file");
  test::write_photo(photo_, {.columns = 9, .rows = 9, .epsg = 0}, false, test::meadow);
  expect_refused(ErrorCode::kBadData, "no georeference");
  test::write_photo(photo_, {.columns = 9, .rows = 9, .west = 90000}, false, test::meadow);
  expect_refused(ErrorCode::kBadData, "does not meet the DEM");
  test::write_photo(photo_, {.columns = 9, .rows = 9}, false, test::meadow);
  OGRSpatialReference local;
  local.SetLocalCS("site");
  GDALDatasetUniquePtr(GDALDataset::Open(photo_.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE))->SetSpatialRef(&local);
  expect_refused(ErrorCode::kBadData, "gdal_translate -a_srs");
  std::filesystem::resize_file(photo_, 0);
  expect_refused(ErrorCode::kBadData, "not recognized");
  std::filesystem::remove(photo_);
  test::write_raster(photo_, {.columns = 9, .rows = 9, .type = test::SampleType::kInt16},
                     [](int c, int r) { return c + r; });
  expect_refused(ErrorCode::kBadData, "gdal_translate -ot Byte -scale LEAST MOST 0 255");
}

}  // namespace
}  // namespace tintree::cache
