#include "tests/support/test_raster.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include <gdal_priv.h>
#include <ogr_spatialref.h>

namespace tintree::test {
namespace {

GDALDataType gdal_type(SampleType type) {
  switch (type) {
    case SampleType::kInt16:
      return GDT_Int16;
    case SampleType::kFloat32:
      return GDT_Float32;
    case SampleType::kFloat64:
      return GDT_Float64;
  }
  return GDT_Float64;
}

}  // namespace

void set_georeference(GDALDataset& dataset, const RasterSpec& spec) {
  if (spec.epsg == 0) return;
  const double c = std::cos(spec.turn_rad);
  const double s = std::sin(spec.turn_rad);
  std::array<double, 6> transform{spec.west, spec.dx * c, spec.dy * s, spec.north, spec.dx * s, -spec.dy * c};
  OGRSpatialReference srs;
  if (dataset.SetGeoTransform(transform.data()) != CE_None || srs.importFromEPSG(spec.epsg) != OGRERR_NONE ||
      dataset.SetSpatialRef(&srs) != CE_None) {
    throw std::runtime_error("GDAL refuses the georeference");
  }
}

void write_raster(const std::string& path, const RasterSpec& spec, const HeightFunction& height) {
  GDALAllRegister();
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  std::vector<std::string> words;
  if (spec.tile > 0) {
    const std::string side = std::to_string(spec.tile);
    words = {"TILED=YES", "BLOCKXSIZE=" + side, "BLOCKYSIZE=" + side};
  }
  if (spec.deflate) words.emplace_back("COMPRESS=DEFLATE");
  std::vector<char*> options;
  for (std::string& word : words) options.push_back(word.data());
  options.push_back(nullptr);
  const GDALDatasetUniquePtr dataset(
      driver->Create(path.c_str(), spec.columns, spec.rows, 1, gdal_type(spec.type), options.data()));
  if (!dataset) throw std::runtime_error("GDAL cannot create " + path);
  set_georeference(*dataset, spec);
  GDALRasterBand* band = dataset->GetRasterBand(1);
  if (spec.nodata) band->SetNoDataValue(*spec.nodata);
  std::vector<double> line(static_cast<std::size_t>(spec.columns));
  for (int r = 0; r < spec.rows; ++r) {
    for (int c = 0; c < spec.columns; ++c) {
      const double h = height(c, r);
      line[static_cast<std::size_t>(c)] = std::isnan(h) && spec.nodata ? *spec.nodata : h;
    }
    if (band->RasterIO(GF_Write, 0, r, spec.columns, 1, line.data(), spec.columns, 1, GDT_Float64, 0, 0, nullptr) !=
        CE_None) {
      throw std::runtime_error("GDAL cannot write " + path);
    }
  }
}

double HeightGrid::at(std::int64_t column, std::int64_t row) const {
  if (column < 0 || row < 0 || column >= columns || row >= rows) return kMissing;
  return heights_m[static_cast<std::size_t>(row * columns + column)];
}

bool HeightGrid::has_lower(std::int64_t c, std::int64_t r) const {
  return std::isfinite(at(c, r) + at(c, r + 1) + at(c + 1, r + 1));
}

bool HeightGrid::has_upper(std::int64_t c, std::int64_t r) const {
  return std::isfinite(at(c, r) + at(c + 1, r + 1) + at(c + 1, r));
}

double HeightGrid::surface(double column, double row) const {
  const auto c = static_cast<std::int64_t>(std::floor(column));
  const auto r = static_cast<std::int64_t>(std::floor(row));
  const double u = column - static_cast<double>(c);
  const double v = row - static_cast<double>(r);
  // Corners of weight 0 may be missing: a point on a hole's border belongs to the surface.
  const auto weighted = [](double weight, double height) { return weight == 0 ? 0 : weight * height; };
  const double corner = u <= v ? at(c, r + 1) : at(c + 1, r);
  return weighted(1 - std::max(u, v), at(c, r)) + weighted(std::abs(u - v), corner) +
         weighted(std::min(u, v), at(c + 1, r + 1));
}

HeightGrid read_grid(const cache::RasterSource& source) {
  HeightGrid grid;
  grid.columns = source.info().columns;
  grid.rows = source.info().rows;
  grid.heights_m.resize(static_cast<std::size_t>(grid.columns * grid.rows));
  if (auto read = source.read(0, 0, grid.columns, grid.rows, grid.heights_m.data()); !read) {
    throw std::runtime_error(read.error().text());
  }
  return grid;
}

HeightGrid read_grid(const std::string& path) {
  auto source = cache::RasterSource::open(path);
  if (!source) throw std::runtime_error(source.error().text());
  return read_grid(*source);
}

double hills(int column, int row, double relief) {
  const double x = column;
  const double y = row;
  const double smooth = std::sin(x * 0.11) * std::cos(y * 0.07) + 0.3 * std::sin(x * 0.31 + y * 0.23);
  const double rough = 0.05 * std::sin(x * 2.7 + y * 1.9) * std::cos(x * 1.3 - y * 3.1);
  return relief * (smooth + rough) / 1.35;
}

double noise(int column, int row, unsigned seed) {
  std::uint32_t h = static_cast<std::uint32_t>(column) * 0x9E3779B1U ^ static_cast<std::uint32_t>(row) * 0x85EBCA77U ^
                    (seed + 1) * 0xC2B2AE3DU;
  for (int i = 0; i < 2; ++i) {
    h ^= h >> 15;
    h *= 0x2C1B3C6DU;
    h ^= h >> 12;
    h *= 0x297A2D39U;
  }
  return static_cast<double>(h ^ (h >> 15)) / 4294967296.0;
}

HeightFunction rough_hills(double relief, double roughness, double holes, unsigned seed) {
  return [=](int c, int r) {
    if (noise(c, r, 7 * seed + 1) < holes) return kMissing;
    return hills(c + static_cast<int>(100 * seed), r, relief) + roughness * noise(c, r, seed);
  };
}

}  // namespace tintree::test
