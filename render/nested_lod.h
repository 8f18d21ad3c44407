#pragma once

#include <array>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "codec/nested_tile.h"
#include "render/camera.h"

namespace tintree::render {

/// The scale of detail at a point (Schneider and Westermann 2006, section 5): how many metres of the world, at the
/// point's depth, one step of `along` on the screen spans, a unit of `along` being a pixel; the length of
///   sum over i of (dv_i/ds_1 along_1 + dv_i/ds_2 along_2) / |along|,
/// v the world and s = (s_1, s_2 in pixels, s_3 the depth in metres), from the inverse of the projection's Jacobian
/// matrix. 0 at the eye's depth and behind it.
double lod_scale_m(const Camera& camera, const glm::dvec3& point, const glm::dvec2& along = {0, 1});

/// The nested level wanted at the corners of a tile's box, real numbers: 0 the coarsest, levels - 1 the tile's own
/// mesh. They grow without end towards the eye. Corner k lies east on the grid if bit 0 of k is set, south if bit 1 is,
/// at the top if bit 2 is.
using CornerLevels = std::array<float, 8>;

/// Level i is wanted where its tolerance, 2^(levels - 1 - i) bounds, is what the pixel error allows:
///   level = levels - 1 - log2(rho / bound_m),    rho = pixel_error * lod_scale_m / vertical_gain
/// (Camera::vertical_gain: the paper's rho leaves out that a point also moves by coming nearer). Interpolated between
/// the corners it is never less than that at a point between them: depth is linear in the plane and its logarithm
/// concave. So the error stays within pixel_error.
CornerLevels corner_levels(const Camera& camera, const std::array<glm::dvec3, 8>& corners, double bound_m, int levels,
                           double pixel_error);

/// Trilinear between the corners, `at` from 0 to 1 east, south and up. The vertex shader does the same.
float level_at(const CornerLevels& corners, const std::array<float, 3>& at);

/// The mesh that holds all vertices that the corners' levels can ask for: the least level not below any of them.
int mesh_level(const CornerLevels& corners, int levels);

/// Weights of the heights on levels 0 to 8 of a vertex at this level: forward differences of the clamped ramps
/// clamp(level - i, 0, 1), the piecewise linear basis (section 5, Geomorphing). They add up to 1 for 0 <= level, and
/// those of the levels from `levels` - 1 on lie on `levels` - 1. The vertex shader does the same.
std::array<float, codec::NestedTile::kMostLevels> morph_weights(float level, int levels);

}  // namespace tintree::render
