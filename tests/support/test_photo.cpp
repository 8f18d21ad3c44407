#include "tests/support/test_photo.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include <gdal_priv.h>
#include <ogr_spatialref.h>

namespace tintree::test {

void write_photo(const std::string& path, const RasterSpec& spec, bool alpha, const PhotoFunction& color) {
  GDALAllRegister();
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  std::array<std::string, 2> words{"PHOTOMETRIC=RGB", "ALPHA=UNSPECIFIED"};
  std::vector<char*> options{words[0].data(), nullptr};
  const int bands = alpha ? 4 : 3;
  const GDALDatasetUniquePtr dataset(
      driver->Create(path.c_str(), spec.columns, spec.rows, bands, GDT_Byte, options.data()));
  if (!dataset) throw std::runtime_error("GDAL cannot create " + path);
  set_georeference(*dataset, spec);
  if (alpha) dataset->GetRasterBand(4)->SetColorInterpretation(GCI_AlphaBand);
  std::vector<std::uint8_t> line(static_cast<std::size_t>(4 * spec.columns));
  for (int r = 0; r < spec.rows; ++r) {
    for (int c = 0; c < spec.columns; ++c) {
      const auto pixel = color(c, r);
      std::copy_n(pixel.begin(), 4, line.begin() + 4 * c);
    }
    if (dataset->RasterIO(GF_Write, 0, r, spec.columns, 1, line.data(), spec.columns, 1, GDT_Byte, bands, nullptr, 4,
                          GSpacing{4} * spec.columns, 1, nullptr) != CE_None) {
      throw std::runtime_error("GDAL cannot write " + path);
    }
  }
}

std::array<std::uint8_t, 4> meadow(int column, int row) {
  const auto wave = [](double v) { return static_cast<std::uint8_t>(std::lround(128 + 90 * std::sin(v))); };
  return {wave(column / 9.0), wave(row / 7.0), wave((column + row) / 11.0), 255};
}

}  // namespace tintree::test
