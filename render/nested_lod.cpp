#include "render/nested_lod.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace tintree::render {
namespace {

/// Levels above the finest that a corner at the eye wants.
constexpr double kNearest = 1000;

}  // namespace

double lod_scale_m(const Camera& camera, const glm::dvec3& point, const glm::dvec2& along) {
  const CameraAxes axes = camera.axes();
  const glm::dvec3 from_eye = point - camera.eye;
  const double depth = glm::dot(axes.forward, from_eye);
  if (depth <= 0) return 0;
  const double f = camera.focal_px() / depth;
  const glm::dvec3 s1 = f * (axes.right - glm::dot(axes.right, from_eye) / depth * axes.forward);
  const glm::dvec3 s2 = f * (axes.up - glm::dot(axes.up, from_eye) / depth * axes.forward);
  // Columns of the inverse of the matrix with these rows.
  const glm::dmat3 inverse = glm::inverse(glm::transpose(glm::dmat3(s1, s2, axes.forward)));
  return glm::length(inverse * glm::dvec3(along, 0)) / glm::length(along);
}

CornerLevels corner_levels(const Camera& camera, const std::array<glm::dvec3, 8>& corners, double bound_m, int levels,
                           double pixel_error) {
  CornerLevels out{};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const double rho = pixel_error * lod_scale_m(camera, corners[k]) / camera.vertical_gain();
    const double above = rho > 0 ? -std::log2(rho / bound_m) : kNearest;
    out[k] = static_cast<float>(levels - 1 + std::min(above, kNearest));
  }
  return out;
}

float level_at(const CornerLevels& corners, const std::array<float, 3>& at) {
  const auto mix = [](float a, float b, float t) { return a * (1 - t) + b * t; };
  std::array<float, 4> up{};
  for (std::size_t k = 0; k < 4; ++k) up[k] = mix(corners[k], corners[k + 4], at[2]);
  return mix(mix(up[0], up[1], at[0]), mix(up[2], up[3], at[0]), at[1]);
}

int mesh_level(const CornerLevels& corners, int levels) {
  const float finest = std::ranges::max(corners);
  return static_cast<int>(std::clamp(std::ceil(finest), 0.0F, static_cast<float>(levels - 1)));
}

std::array<float, codec::NestedTile::kMostLevels> morph_weights(float level, int levels) {
  std::array<float, codec::NestedTile::kMostLevels> out{};
  float before = 1;
  for (int i = 0; i < levels; ++i) {
    const float ramp = i < levels - 1 ? std::clamp(level - static_cast<float>(i), 0.0F, 1.0F) : 0;
    out[static_cast<std::size_t>(i)] = before - ramp;
    before = ramp;
  }
  return out;
}

}  // namespace tintree::render
