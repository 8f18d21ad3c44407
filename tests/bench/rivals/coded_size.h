#pragma once

#include <cstdint>

#include "codec/error.h"
#include "tests/bench/rivals/height_grid.h"
#include "tests/bench/rivals/triangle_mesh.h"

namespace tintree::bench {

struct CodedMesh {
  std::uint64_t bytes = 0;
  double decode_seconds = 0;  ///< Least processor time of decoding.
};

/// A mesh under the coder of tintree's own tiles, without loss: x, y on whole samples if all vertices lie
/// there, else on eighths; heights on multiples of `height_step_m`. Fails where the mesh does not lie on
/// that lattice.
Expected<CodedMesh> code_mesh(const HeightGrid& grid, const TriangleMesh& mesh, double height_step_m);

/// A raster under JPEG-LS (CharLS) as one image whose samples are whole metres in 16 bits.
struct CodedRaster {
  std::uint64_t bytes = 0;
  double max_error_m = 0;  ///< Of what was decoded again.
  double rms_m = 0;
  double seconds = 0;         ///< Processor time of encoding.
  double decode_seconds = 0;  ///< Least processor time of decoding.
};

/// Near-lossless within whole `error_m`; from 256 m on, which the format cannot say, lossless over
/// heights quantised to multiples of 2 * error_m + 1.
Expected<CodedRaster> jpegls(const HeightGrid& grid, int error_m);

}  // namespace tintree::bench
