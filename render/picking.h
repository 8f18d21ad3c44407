#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include <glm/vec3.hpp>

#include "cache/drawable_tile.h"
#include "cache/tile_ref.h"
#include "render/lod_cut.h"

namespace tintree::render {

/// A half-line in the world frame: origin + t * direction, t >= 0; `direction` of any length but 0.
struct Ray {
  glm::dvec3 origin;
  glm::dvec3 direction;
};

/// A place on the ground.
struct GroundPoint {
  glm::dvec3 at{0, 0, 0};  ///< World frame, metres.
  double t = 0;            ///< Along the ray, in lengths of its direction.
  std::uint32_t tree = 0;  ///< Of the tile that was hit,
  std::uint32_t node = 0;  ///< and its index into TileBounds::nodes().
};

/// A tile's arrays if they are in memory, else null.
using FindTile = std::function<std::shared_ptr<const cache::DrawableTile>(const cache::TileRef&)>;

/// The smallest t at which the ray meets the tile's surface (not its skirt), from either side.
/// Cost: about 10 ns a triangle.
std::optional<double> first_hit(const cache::DrawableTile& tile, const Ray& ray);

/// Where the ray meets the ground first, by the finest tiles that `find` has; a coarser one counts only where
/// finer ones are missing. Walks each tree's boxes front to back. None when it misses all.
std::optional<GroundPoint> pick(Trees trees, const FindTile& find, const Ray& ray);

/// The ground under or over a place (metres east and north), as pick() finds it along the vertical. None beside the
/// terrain, in its holes, and where no tile is in memory.
std::optional<GroundPoint> ground_at(Trees trees, const FindTile& find, double x_m, double y_m);

}  // namespace tintree::render
