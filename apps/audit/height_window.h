#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cache/raster_source.h"
#include "codec/grid_frame.h"

namespace tintree::audit {

/// DEM cells along the side of the windows in which tiles are measured.
inline constexpr std::int64_t kWindowCells = 512;

/// The reference surface over a few cells of one tile. Coordinates are tile-local: sample (0, 0) is the
/// tile's north-west corner. Holds the window's own samples and one more column and row on the west and
/// north, so that the triangles beyond those sides are known.
class HeightWindow {
 public:
  /// Reads the samples of `local`, a part of `tile` given relative to its corner. Reuses its memory.
  Expected<void> read(const cache::RasterSource& source, const codec::CellRect& tile, const codec::CellRect& local);

  /// Cells of the window, tile-local.
  const codec::CellRect& cells() const { return cells_; }
  /// Cells of the whole tile along x and y.
  std::int64_t tile_width() const { return tile_width_; }
  std::int64_t tile_height() const { return tile_height_; }

  /// Height of a sample in metres, NaN when missing. Valid one sample beyond the west and north sides.
  double at(std::int64_t column, std::int64_t row) const { return this->row(row)[column]; }
  /// Pointer by which row `r` is indexed with tile-local columns.
  const double* row(std::int64_t r) const {
    return heights_.data() + (r - cells_.row0 + 1) * stride_ + (1 - cells_.column0);
  }

  /// The surface at a lattice point inside the window; NaN where there is none. A missing sample of
  /// weight 0 does not count.
  double surface(std::int32_t x, std::int32_t y, int units) const;

  /// Which reference triangles of a row of cells exist, for the cells from one west of the window to its
  /// last: bit 0 the lower one (north-west, south-west, south-east), bit 1 the upper one (north-west,
  /// south-east, north-east). Cells outside the tile have none.
  void triangles_of_row(std::int64_t row, std::vector<std::uint8_t>& out) const;

  /// Whether any reference triangle of the window's own cells exists.
  bool has_surface() const;

 private:
  codec::CellRect cells_;
  std::int64_t tile_width_ = 0;
  std::int64_t tile_height_ = 0;
  std::ptrdiff_t stride_ = 0;
  std::vector<double> heights_;
};

inline constexpr std::uint8_t kLower = 1;
inline constexpr std::uint8_t kUpper = 2;

/// Height between two samples, `share` of the way from the first; a missing sample of weight 0 does not
/// count. Shares within 1e-9 of a sample are taken as on it.
inline double between(double first, double second, double share) {
  return share < 1e-9 ? first : first + share * (second - first);
}

}  // namespace tintree::audit
