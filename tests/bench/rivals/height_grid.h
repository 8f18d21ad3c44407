#pragma once

#include <string>
#include <vector>

#include "codec/error.h"

namespace tintree::bench {

/// A DEM window without holes: the reference surface of the comparison, whose cells are cut from their
/// north-west to their south-east sample (docs/accuracy.md). Heights in metres, row-major, north row first.
struct HeightGrid {
  int columns = 0;
  int rows = 0;
  double dx_m = 1;
  double dy_m = 1;
  std::vector<float> heights_m;

  double at(int column, int row) const {
    return heights_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                     static_cast<std::size_t>(column)];
  }

  /// The surface's height at a point of the grid's plane, which must lie inside.
  double surface(double column, double row) const;
};

/// Reads 32-bit floats in the machine's byte order, as many as `shape` has samples.
Expected<HeightGrid> read_grid(const std::string& path, HeightGrid shape);

}  // namespace tintree::bench
