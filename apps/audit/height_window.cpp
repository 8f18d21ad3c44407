#include "apps/audit/height_window.h"

#include <algorithm>

namespace tintree::audit {

Expected<void> HeightWindow::read(const cache::RasterSource& source, const codec::CellRect& tile,
                                  const codec::CellRect& local) {
  cells_ = local;
  tile_width_ = tile.column1 - tile.column0;
  tile_height_ = tile.row1 - tile.row0;
  stride_ = local.column1 - local.column0 + 2;
  const std::int64_t lines = local.row1 - local.row0 + 2;
  heights_.resize(static_cast<std::size_t>(stride_ * lines));
  return source.read(tile.column0 + local.column0 - 1, tile.row0 + local.row0 - 1, stride_, lines, heights_.data());
}

double HeightWindow::surface(std::int32_t x, std::int32_t y, int units) const {
  const std::int64_t c = x / units;
  const std::int64_t r = y / units;
  const double u = static_cast<double>(x % units) / units;
  const double v = static_cast<double>(y % units) / units;
  if (v == 0) return u == 0 ? at(c, r) : between(at(c, r), at(c + 1, r), u);
  if (u == 0) return between(at(c, r), at(c, r + 1), v);
  const double north_west = at(c, r);
  const double south_east = at(c + 1, r + 1);
  if (u == v) return between(north_west, south_east, u);
  if (u < v) {
    const double south_west = at(c, r + 1);
    return north_west + v * (south_west - north_west) + u * (south_east - south_west);
  }
  const double north_east = at(c + 1, r);
  return north_west + u * (north_east - north_west) + v * (south_east - north_east);
}

void HeightWindow::triangles_of_row(std::int64_t row, std::vector<std::uint8_t>& out) const {
  const std::int64_t width = cells_.column1 - cells_.column0 + 1;
  out.assign(static_cast<std::size_t>(width), 0);
  if (row < 0 || row >= tile_height_) return;
  const double* north = this->row(row);
  const double* south = this->row(row + 1);
  for (std::int64_t i = cells_.column0 > 0 ? 0 : 1; i < width; ++i) {
    const std::int64_t c = cells_.column0 - 1 + i;
    const double diagonal = north[c] + south[c + 1];
    const bool lower = !std::isnan(diagonal + south[c]);
    const bool upper = !std::isnan(diagonal + north[c + 1]);
    out[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>((lower ? kLower : 0) | (upper ? kUpper : 0));
  }
}

bool HeightWindow::has_surface() const {
  std::vector<std::uint8_t> triangles;
  for (std::int64_t r = cells_.row0; r < cells_.row1; ++r) {
    triangles_of_row(r, triangles);
    if (std::any_of(triangles.begin() + 1, triangles.end(), [](std::uint8_t t) { return t != 0; })) return true;
  }
  return false;
}

}  // namespace tintree::audit
