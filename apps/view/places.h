#pragma once

#include <array>
#include <string>

#include <glm/vec3.hpp>

#include "cache/manifest.h"

namespace tintree::view {

/// Coordinates of a place (world frame, metres) in the units of the DEM's CRS: x, y; longitude and latitude in degrees
/// for a geographic one.
std::array<double, 2> crs_coordinates(const cache::Manifest& manifest, const glm::dvec3& world_m);

/// One line: where a place is in the world frame, in the CRS, and how high.
std::string place_text(const cache::Manifest& manifest, const glm::dvec3& world_m);

}  // namespace tintree::view
