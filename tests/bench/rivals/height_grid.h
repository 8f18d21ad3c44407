#pragma once

#include <string>
#include <vector>

#include "codec/error.h"

namespace tintree::bench {

/// A DEM window: the reference surface of the comparison, whose cells are cut from their north-west to their
/// south-east sample (docs/accuracy.md). Heights in metres, row-major, north row first; NaN for none.
struct HeightGrid {
  int columns = 0;
  int rows = 0;
  double dx_m = 1;
  double dy_m = 1;
  std::vector<double> heights_m;

  double at(int column, int row) const {
    return heights_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                     static_cast<std::size_t>(column)];
  }

  /// Whether cell (column, row) has its triangle below the diagonal (north-west, south-west, south-east), and
  /// the one above it (north-west, south-east, north-east).
  bool has_lower(int column, int row) const;
  bool has_upper(int column, int row) const;
  bool has_holes() const;

  /// The surface's height at a point of the grid's plane, which must lie inside; NaN in a hole.
  double surface(double column, double row) const;
};

/// Reads 64-bit floats in the machine's byte order, as many as `shape` has samples.
Expected<HeightGrid> read_grid(const std::string& path, HeightGrid shape);

}  // namespace tintree::bench
