#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simplify/height_lattice.h"
#include "simplify/reference_surface.h"

namespace tintree::simplify {

/// The samples of one of the residual pyramid's smallest squares, row-major from the north-west, copied for the tests
/// of all triangles in it.
struct SquareSamples {
  static constexpr std::int64_t kCells = kPatchCells[0];
  static constexpr std::size_t kLine = kCells + 1;
  using Samples = std::array<std::array<double, kLine>, kLine>;

  Samples samples;
  Samples snapped;  ///< On the lattice.

  /// Of the square with this north-west corner in the DEM, which lies in one block; false when a sample is missing,
  /// which leaves them undefined.
  bool read(SurfaceView& view, std::int64_t column, std::int64_t row, const HeightLattice& heights);
};

}  // namespace tintree::simplify
