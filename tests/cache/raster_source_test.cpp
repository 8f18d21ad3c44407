#include "cache/raster_source.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include "tests/support/temp_dir.h"

namespace tintree::cache {
namespace {

using test::TempDir;

/// A GeoTIFF with every oddity that a test may want.
struct Spec {
  int columns = 5;
  int rows = 4;
  GDALDataType type = GDT_Float64;
  std::string crs = "EPSG:32610";  ///< Anything that GDAL understands; empty for none.
  std::optional<std::array<double, 6>> geotransform = {{500000, 10, 0, 4000000, 0, -20}};
  std::optional<double> nodata;
  std::optional<double> scale;
  std::optional<double> offset;
  std::string unit;
  std::vector<std::string> options;
};

using Value = std::function<double(int column, int row)>;

void write_tiff(const std::string& path, const Spec& spec, const Value& value) {
  GDALAllRegister();
  std::vector<const char*> options;
  for (const auto& o : spec.options) options.push_back(o.c_str());
  options.push_back(nullptr);
  const GDALDatasetUniquePtr dataset(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), spec.columns, spec.rows, 1, spec.type, const_cast<char**>(options.data())));
  if (!dataset) throw std::runtime_error("GDAL cannot create " + path);
  if (spec.geotransform) dataset->SetGeoTransform(const_cast<double*>(spec.geotransform->data()));
  if (!spec.crs.empty()) {
    OGRSpatialReference srs;
    if (srs.SetFromUserInput(spec.crs.c_str()) != OGRERR_NONE) throw std::runtime_error("no such CRS: " + spec.crs);
    dataset->SetSpatialRef(&srs);
  }
  GDALRasterBand* band = dataset->GetRasterBand(1);
  if (spec.nodata) band->SetNoDataValue(*spec.nodata);
  if (spec.scale) band->SetScale(*spec.scale);
  if (spec.offset) band->SetOffset(*spec.offset);
  if (!spec.unit.empty()) band->SetUnitType(spec.unit.c_str());
  for (int r = 0; r < spec.rows; ++r) {
    for (int c = 0; c < spec.columns; ++c) {
      double v = value(c, r);
      if (band->RasterIO(GF_Write, c, r, 1, 1, &v, 1, 1, GDT_Float64, 0, 0, nullptr) != CE_None) {
        throw std::runtime_error("GDAL cannot write " + path);
      }
    }
  }
}

std::vector<double> read_window(const RasterSource& source, std::int64_t column, std::int64_t row, std::int64_t width,
                                std::int64_t height) {
  std::vector<double> out(static_cast<std::size_t>(width * height), -12345);
  const auto done = source.read(column, row, width, height, out.data());
  EXPECT_TRUE(done.has_value()) << done.error().text();
  return out;
}

class RasterSourceTest : public testing::Test {
 protected:
  RasterSource open(const Spec& spec, const Value& value) {
    const std::string path = dir_.file("dem.tif");
    write_tiff(path, spec, value);
    auto source = RasterSource::open(path);
    if (!source) throw std::runtime_error(source.error().text());
    return std::move(*source);
  }
  Error refusal(const Spec& spec) {
    const std::string path = dir_.file("bad.tif");
    write_tiff(path, spec, [](int, int) { return 1.0; });
    auto source = RasterSource::open(path);
    if (source) throw std::runtime_error("was accepted");
    EXPECT_EQ(source.error().where, path);
    return source.error();
  }

  TempDir dir_;
};

TEST_F(RasterSourceTest, ReadsEverySampleType) {
  const auto small = [](int c, int r) { return 10.0 * r + c; };
  const auto wide = [](int c, int r) { return 1000.0 * r + c; };
  const auto negative = [](int c, int r) { return -1000.0 * r - c; };
  const auto large = [](int c, int r) { return -100000000.0 + 12345.0 * r + c; };
  const auto fraction = [](int c, int r) { return 1234.5 + r / 8.0 - c / 64.0; };
  const auto fine = [](int c, int r) { return 1e6 / 3 + r * 1e-7 + c; };
  const std::vector<std::pair<GDALDataType, Value>> kinds = {{GDT_Byte, small},       {GDT_UInt16, wide},
                                                             {GDT_Int16, negative},   {GDT_Int32, large},
                                                             {GDT_Float32, fraction}, {GDT_Float64, fine}};
  for (const auto& [type, value] : kinds) {
    SCOPED_TRACE(GDALGetDataTypeName(type));
    Spec spec;
    spec.type = type;
    const RasterSource source = open(spec, value);
    EXPECT_EQ(source.info().columns, 5);
    EXPECT_EQ(source.info().rows, 4);
    const auto all = read_window(source, 0, 0, 5, 4);
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 5; ++c) EXPECT_EQ(all[static_cast<std::size_t>(r * 5 + c)], value(c, r));
    }
  }
}

TEST_F(RasterSourceTest, DeclaredNodataIsNaN) {
  for (const auto& [type, nodata] : {std::pair{GDT_Int16, -32768.0},
                                     {GDT_Byte, 0.0},
                                     {GDT_Float32, -9999.0},
                                     // Not exact in 32 bits: the file holds its rounded form.
                                     {GDT_Float32, -9999.9},
                                     {GDT_Float64, -1.7976931348623157e308},
                                     {GDT_Float32, -3.4028234663852886e38}}) {
    SCOPED_TRACE(GDALGetDataTypeName(type));
    Spec spec;
    spec.type = type;
    spec.nodata = nodata;
    const double missing = nodata;
    const RasterSource source = open(spec, [missing](int c, int r) { return c == 2 && r == 1 ? missing : 7; });
    const auto all = read_window(source, 0, 0, 5, 4);
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i == 7) {
        EXPECT_TRUE(std::isnan(all[i]));
      } else {
        EXPECT_EQ(all[i], 7);
      }
    }
  }
}

TEST_F(RasterSourceTest, NaNAndInfinityAreNaN) {
  for (const GDALDataType type : {GDT_Float32, GDT_Float64}) {
    Spec spec;
    spec.type = type;
    const RasterSource source = open(spec, [](int c, int) {
      if (c == 0) return std::numeric_limits<double>::quiet_NaN();
      if (c == 1) return std::numeric_limits<double>::infinity();
      return c == 2 ? -std::numeric_limits<double>::infinity() : 3.0;
    });
    const auto row = read_window(source, 0, 0, 5, 1);
    EXPECT_TRUE(std::isnan(row[0]) && std::isnan(row[1]) && std::isnan(row[2]));
    EXPECT_EQ(row[3], 3);
  }
}

TEST_F(RasterSourceTest, MaskBandCutsSamplesOut) {
  const std::string path = dir_.file("masked.tif");
  write_tiff(path, {}, [](int c, int r) { return c + 10.0 * r; });
  {
    CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", "YES");
    const GDALDatasetUniquePtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
    ASSERT_EQ(dataset->CreateMaskBand(GMF_PER_DATASET), CE_None);
    GDALRasterBand* mask = dataset->GetRasterBand(1)->GetMaskBand();
    mask->Fill(255);
    unsigned char zero = 0;
    ASSERT_EQ(mask->RasterIO(GF_Write, 3, 2, 1, 1, &zero, 1, 1, GDT_Byte, 0, 0, nullptr), CE_None);
    CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", nullptr);
  }
  const auto source = RasterSource::open(path);
  ASSERT_TRUE(source.has_value());
  const auto window = read_window(*source, 2, 1, 4, 3);  // one column beyond the east side
  EXPECT_TRUE(std::isnan(window[5]));
  EXPECT_EQ(window[4], 22);
  EXPECT_EQ(window[6], 24);
  EXPECT_TRUE(std::isnan(window[7]));
}

TEST_F(RasterSourceTest, ScaleAndOffsetApplyToHeightsButNotToNodata) {
  Spec spec;
  spec.type = GDT_Int16;
  spec.nodata = -1;
  spec.scale = 0.5;
  spec.offset = 100;
  const RasterSource source = open(spec, [](int c, int) { return c - 1.0; });
  const auto row = read_window(source, 0, 0, 5, 1);
  EXPECT_TRUE(std::isnan(row[0]));
  for (std::size_t c = 1; c < 5; ++c) EXPECT_EQ(row[c], 100 + 0.5 * (static_cast<double>(c) - 1));
}

TEST_F(RasterSourceTest, HeightUnitIsConverted) {
  for (const auto& [unit, metres] : {std::pair{"ft", 0.3048},
                                     {"foot", 0.3048},
                                     {"us-ft", 1200.0 / 3937},
                                     {"US survey foot", 1200.0 / 3937},
                                     {"metre", 1.0},
                                     {"m", 1.0},
                                     {"cm", 0.01}}) {
    SCOPED_TRACE(unit);
    Spec spec;
    spec.unit = unit;
    const RasterSource source = open(spec, [](int, int) { return 1000.0; });
    EXPECT_DOUBLE_EQ(source.info().height_unit_m, metres);
    EXPECT_DOUBLE_EQ(read_window(source, 0, 0, 1, 1)[0], 1000 * metres);
    EXPECT_TRUE(source.info().warnings.empty());
  }
  Spec spec;
  spec.unit = "furlong";
  const RasterSource source = open(spec, [](int, int) { return 1.0; });
  EXPECT_EQ(source.info().height_unit_m, 1);
  ASSERT_EQ(source.info().warnings.size(), 1U);
  EXPECT_NE(source.info().warnings[0].find("furlong"), std::string::npos);
}

TEST_F(RasterSourceTest, CrsInFeetGivesSpacingInMetres) {
  Spec spec;
  spec.crs = "EPSG:2225";  // California zone 1, US survey feet
  spec.geotransform = {{6000000, 2, 0, 2000000, 0, -3}};
  const RasterSource source = open(spec, [](int, int) { return 100.0; });
  const double foot = 1200.0 / 3937;
  EXPECT_NEAR(source.info().dx_m, 2 * foot, 1e-12);
  EXPECT_NEAR(source.info().dy_m, 3 * foot, 1e-12);
  // No height unit is stated: the CRS's unit is taken, and said.
  EXPECT_NEAR(read_window(source, 0, 0, 1, 1)[0], 100 * foot, 1e-9);
  EXPECT_FALSE(source.info().warnings.empty());
}

TEST_F(RasterSourceTest, VerticalPartOfTheCrsStatesTheHeightUnit) {
  Spec spec;
  spec.crs = "EPSG:32610+6360";  // UTM 10N with NAVD88 heights in US survey feet
  spec.options = {"GEOTIFF_VERSION=1.1"};
  const RasterSource source = open(spec, [](int, int) { return 100.0; });
  EXPECT_NEAR(source.info().height_unit_m, 1200.0 / 3937, 1e-12);
  EXPECT_NEAR(source.info().dx_m, 10, 1e-12);
}

/// Metres per degree on WGS 84 by the usual series (coefficients of the NGA), good to a decimetre.
std::array<double, 2> series_metres_per_degree(double latitude_deg) {
  const double p = latitude_deg * std::numbers::pi / 180;
  return {111132.92 - 559.82 * std::cos(2 * p) + 1.175 * std::cos(4 * p) - 0.0023 * std::cos(6 * p),
          111412.84 * std::cos(p) - 93.5 * std::cos(3 * p) + 0.118 * std::cos(5 * p)};
}

TEST_F(RasterSourceTest, DegreesBecomeMetresAtTheMiddle) {
  for (const double north : {0.002, 20.0, 45.0, 71.5, -33.25}) {
    SCOPED_TRACE(north);
    Spec spec;
    spec.crs = "EPSG:4326";
    const double step = 0.001;
    spec.geotransform = {{-84, step, 0, north, 0, -2 * step}};
    const RasterSource source = open(spec, [](int, int) { return 1.0; });
    EXPECT_TRUE(source.info().geographic);
    const auto [per_latitude, per_longitude] = series_metres_per_degree(north - 4 * step);
    EXPECT_NEAR(source.info().dy_m, 2 * step * per_latitude, 2 * step * 0.1);
    EXPECT_NEAR(source.info().dx_m, step * per_longitude, step * 0.1);
  }
}

TEST_F(RasterSourceTest, DegreesOnAnotherBody) {
  Spec spec;
  spec.crs = "+proj=longlat +R=1737400 +no_defs";
  spec.geotransform = {{10, 0.01, 0, 60.02, 0, -0.01}};  // the middle lies at 60 degrees
  const RasterSource source = open(spec, [](int, int) { return 1.0; });
  const double degree = 1737400 * std::numbers::pi / 180;
  EXPECT_NEAR(source.info().dy_m, 0.01 * degree, 1e-6);
  EXPECT_NEAR(source.info().dx_m, 0.01 * degree / 2, 1e-6);
}

TEST_F(RasterSourceTest, NoGeoreferenceMeansOneMetreAndAWarning) {
  Spec spec;
  spec.crs.clear();
  spec.geotransform.reset();
  const RasterSource source = open(spec, [](int, int) { return 1.0; });
  EXPECT_EQ(source.info().dx_m, 1);
  EXPECT_EQ(source.info().dy_m, 1);
  EXPECT_TRUE(source.info().crs_wkt.empty());
  EXPECT_EQ(source.info().warnings.size(), 1U);
}

TEST_F(RasterSourceTest, NoCrsMeansUnitsAreMetresAndAWarning) {
  Spec spec;
  spec.crs.clear();
  const RasterSource source = open(spec, [](int, int) { return 1.0; });
  EXPECT_EQ(source.info().dx_m, 10);
  EXPECT_EQ(source.info().dy_m, 20);
  EXPECT_EQ(source.info().warnings.size(), 1U);
}

TEST_F(RasterSourceTest, BeyondTheRasterIsNaN) {
  const RasterSource source = open({}, [](int c, int r) { return c + 10.0 * r; });
  for (const auto& [column, row, width, height] : {std::array<int, 4>{-2, -3, 10, 10},
                                                   {3, 2, 5, 5},
                                                   {-4, 1, 5, 2},
                                                   {0, 0, 5, 4},
                                                   {5, 0, 3, 3},
                                                   {-3, 0, 3, 3},
                                                   {100, 100, 2, 2}}) {
    const auto window = read_window(source, column, row, width, height);
    for (int j = 0; j < height; ++j) {
      for (int i = 0; i < width; ++i) {
        const int c = column + i;
        const int r = row + j;
        const double got = window[static_cast<std::size_t>(j * width + i)];
        if (c < 0 || r < 0 || c >= 5 || r >= 4) {
          EXPECT_TRUE(std::isnan(got)) << c << ", " << r;
        } else {
          EXPECT_EQ(got, c + 10.0 * r);
        }
      }
    }
  }
}

TEST_F(RasterSourceTest, SeveralThreadsReadOneSource) {
  Spec spec;
  spec.columns = 64;
  spec.rows = 64;
  const RasterSource source = open(spec, [](int c, int r) { return c + 100.0 * r; });
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&source, t] {
      for (int i = 0; i < 200; ++i) {
        const int row = (t * 13 + i) % 64;
        std::array<double, 64> line{};
        ASSERT_TRUE(source.read(0, row, 64, 1, line.data()).has_value());
        for (int c = 0; c < 64; ++c) ASSERT_EQ(line[static_cast<std::size_t>(c)], c + 100.0 * row);
      }
    });
  }
}

TEST_F(RasterSourceTest, MissingFile) {
  const auto source = RasterSource::open(dir_.file("nowhere.tif"));
  ASSERT_FALSE(source.has_value());
  EXPECT_EQ(source.error().code, ErrorCode::kIo);
  EXPECT_NE(source.error().text().find("nowhere.tif: no such file"), std::string::npos);
}

TEST_F(RasterSourceTest, Directory) {
  const auto source = RasterSource::open(dir_.path());
  ASSERT_FALSE(source.has_value());
  EXPECT_EQ(source.error().code, ErrorCode::kIo);
}

TEST_F(RasterSourceTest, FilesThatAreNoRaster) {
  const std::string path = dir_.file("notes.tif");
  for (const std::string content : {"", "heights, as far as I remember them\n", "II*"}) {
    test::write_file(path, content);
    const auto source = RasterSource::open(path);
    ASSERT_FALSE(source.has_value());
    EXPECT_EQ(source.error().code, ErrorCode::kBadData);
    EXPECT_EQ(source.error().where, path);
  }
}

TEST_F(RasterSourceTest, TooFewSamples) {
  Spec spec;
  spec.rows = 1;
  EXPECT_EQ(refusal(spec).code, ErrorCode::kBadData);
  EXPECT_NE(refusal(spec).message.find("5 x 1"), std::string::npos);
  spec.rows = 4;
  spec.columns = 1;
  EXPECT_EQ(refusal(spec).code, ErrorCode::kBadData);
}

TEST_F(RasterSourceTest, EverySampleLiesWhereTheFilePutsIt) {
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  const std::vector<std::array<double, 6>> transforms = {{500000, 10, 0, 4000000, 0, -20},   // north-up
                                                         {500000, 10, 0, 4000000, 0, 20},    // south-up
                                                         {500000, -10, 0, 4000000, 0, -20},  // east to west
                                                         {500000, -10, 0, 4000000, 0, 20},
                                                         {500000, 0, 20, 4000000, 10, 0},
                                                         {500000, 0, -20, 4000000, 10, 0},
                                                         {500000, 10 * c, 20 * s, 4000000, 10 * s, -20 * c},
                                                         {500000, -10 * c, 20 * s, 4000000, 10 * s, 20 * c},
                                                         {500000, 10, 7, 4000000, 3, -20}};  // sheared
  for (const auto& t : transforms) {
    SCOPED_TRACE(testing::PrintToString(t));
    Spec spec;
    spec.geotransform = t;
    // The height tells the place in the file.
    const RasterSource source = open(spec, [](int column, int row) { return column + 100.0 * row; });
    const RasterInfo& info = source.info();
    const auto& column = info.axes.column;
    const auto& row = info.axes.row;
    EXPECT_LT(column[0] * row[1] - column[1] * row[0], 0) << "rows do not run clockwise of columns";
    EXPECT_NEAR(info.dx_m, std::hypot(t[1], t[4]), 1e-9);
    EXPECT_NEAR(info.dy_m, std::hypot(t[2], t[5]), 1e-9);
    const auto& g = info.geotransform;
    const std::array<double, 2> origin{g[0] + (g[1] + g[2]) / 2, g[3] + (g[4] + g[5]) / 2};
    for (std::int64_t r = 0; r < info.rows; ++r) {
      for (std::int64_t i = 0; i < info.columns; ++i) {
        const double height = read_window(source, i, r, 1, 1)[0];
        const double pixel = std::fmod(height, 100) + 0.5;
        const double line = std::floor(height / 100) + 0.5;
        const auto world = info.axes.world(static_cast<double>(i) * info.dx_m, static_cast<double>(r) * info.dy_m);
        EXPECT_NEAR(origin[0] + world[0], t[0] + pixel * t[1] + line * t[2], 1e-6);
        EXPECT_NEAR(origin[1] + world[1], t[3] + pixel * t[4] + line * t[5], 1e-6);
      }
    }
    // Windows give what single samples give.
    const auto window = read_window(source, 1, 1, 5, 3);
    for (std::int64_t j = 0; j < 3; ++j) {
      for (std::int64_t i = 0; i < 5; ++i) {
        const double one = read_window(source, 1 + i, 1 + j, 1, 1)[0];
        const double many = window[static_cast<std::size_t>(j * 5 + i)];
        EXPECT_TRUE(one == many || (std::isnan(one) && std::isnan(many))) << i << ", " << j;
      }
    }
  }
}

TEST_F(RasterSourceTest, NorthUpOnceMirrored) {
  Spec spec;
  spec.geotransform = {{500000, -10, 0, 4000000, 0, 20}};
  const RasterSource source = open(spec, [](int, int) { return 1.0; });
  EXPECT_EQ(source.info().axes, codec::GridAxes{});
  EXPECT_EQ(source.info().geotransform, (GeoTransform{499950, 10, 0, 4000080, 0, -20}));
}

TEST_F(RasterSourceTest, TransformWithoutArea) {
  Spec spec;
  spec.geotransform = {{500000, 10, 10, 4000000, 5, 5}};
  EXPECT_EQ(refusal(spec).code, ErrorCode::kBadData);
}

TEST_F(RasterSourceTest, ComplexNumbers) {
  Spec spec;
  spec.type = GDT_CFloat32;
  EXPECT_EQ(refusal(spec).code, ErrorCode::kBadData);
}

TEST_F(RasterSourceTest, TruncatedFileIsReported) {
  Spec spec;
  spec.columns = 200;
  spec.rows = 200;
  const std::string path = dir_.file("cut.tif");
  write_tiff(path, spec, [](int c, int r) { return c * r; });
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  auto source = RasterSource::open(path);
  if (source) {
    std::vector<double> all(200 * 200);
    const auto done = source->read(0, 0, 200, 200, all.data());
    ASSERT_FALSE(done.has_value());
    EXPECT_EQ(done.error().code, ErrorCode::kIo);
    EXPECT_EQ(done.error().where, path);
  }
}

}  // namespace
}  // namespace tintree::cache
