#include "render/scalar_placement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <glm/gtc/type_ptr.hpp>

#include "codec/scalar_grid.h"

namespace tintree::render {
namespace {

/// So far out the lattice's origin stays where it is, so that differences fit into 32 bits.
std::int64_t nearest_step(double steps) {
  constexpr double kMost = cache::QuantizedShape::kFarthest;
  return std::llround(std::clamp(steps, -kMost, kMost));
}

}  // namespace

ScalarPlacement place_scalar(const codec::GridFrame& frame, const cache::QuantizedFormat& format,
                             const std::array<double, 3>& eye) {
  const auto [across_m, down_m] = frame.axes.grid(eye[0] - frame.origin_m[0], eye[1] - frame.origin_m[1]);
  codec::GridFrame lattice = frame;
  lattice.xy_shift = 0;
  lattice.column0 = nearest_step(across_m / frame.dx_m);
  lattice.row0 = nearest_step(down_m / frame.dy_m);
  lattice.z_offset = nearest_step(eye[2] / frame.z_step_m);
  ScalarPlacement out;
  out.lattice_to_eye = glm::mat4(glm::make_mat4(lattice.matrix(eye).data()));
  out.index_to_eye =
      glm::mat4(glm::make_mat4(frame.matrix(eye).data()) *
                glm::make_mat4(codec::inverse_quantization(codec::GridBlock{}, format.step, format.low).data()));
  out.corner =
      glm::ivec3(frame.column0 - lattice.column0, frame.row0 - lattice.row0, frame.z_offset - lattice.z_offset);
  out.samples_shift = frame.xy_shift;
  return out;
}

}  // namespace tintree::render
