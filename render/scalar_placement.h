#pragma once

#include <array>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "cache/quantized_shape.h"
#include "codec/grid_frame.h"

namespace tintree::render {

/// Where shaders/scalar_draw.vert.glsl puts the vertices of a tile of method `scalar`: metres east, north, up of the
/// eye.
///
/// Inside, inverse quantisation and the tile's place are one matrix (Fowler et al., equation 5). On its sides, which
/// tiles with other quantisers share, a vertex is first placed in whole samples and height steps on a lattice that all
/// tiles of its level have in common, and then by one matrix: tiles that share a vertex get the same floats, bit for
/// bit, whatever their quantisers, origins and strides are. So are vertices that are looked up in a table.
struct ScalarPlacement {
  glm::mat4 index_to_eye{1};    ///< Of (x, y, index of the height, 1).
  glm::mat4 lattice_to_eye{1};  ///< Of (column, row, height step, 1) from the lattice's origin, which is near the eye.
  glm::ivec3 corner{0};         ///< On the lattice: the tile's north-west corner, at height address 0.
  int samples_shift = 0;        ///< An address step is 2^samples_shift samples.

  glm::ivec3 on_lattice(glm::ivec3 address) const {
    return corner + glm::ivec3(address.x << samples_shift, address.y << samples_shift, address.z);
  }
};

/// `frame`: of a tile that has a QuantizedShape, `format` that one's; `eye`: metres, as frame.matrix() takes it.
ScalarPlacement place_scalar(const codec::GridFrame& frame, const cache::QuantizedFormat& format,
                             const std::array<double, 3>& eye);

}  // namespace tintree::render
