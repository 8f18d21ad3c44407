#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/audit/tile_surface.h"
#include "codec/tile_id.h"

namespace tintree::audit {

/// An edge of a mesh that lies on a side of its tile: positions along the side in eighths of a sample
/// from the raster's corner, heights in the level's global steps.
struct SideEdge {
  std::int64_t begin = 0;
  std::int64_t end = 0;
  std::int64_t begin_height = 0;
  std::int64_t end_height = 0;

  friend bool operator==(const SideEdge&, const SideEdge&) = default;
};

/// The open edges on one side, ascending.
using SideLine = std::vector<SideEdge>;

enum Side { kWest = 0, kNorth = 1, kEast = 2, kSouth = 3 };

/// The four sides of a tile's full square. On a side where the raster ends there is no neighbour.
std::array<SideLine, 4> side_lines(const TileSurface& surface);

/// How two neighbours differ along their common side.
struct BorderFault {
  std::uint64_t count = 0;
  double position = 0;                 ///< First place, in samples along the side from the raster's corner.
  std::int64_t height_difference = 0;  ///< Largest seen at equal positions, in height steps.
};

/// Wherever both meshes have surface along the line, both must have the same edges: the same vertices at
/// the same heights, bit for bit. Where one has a hole there is nothing to agree on.
std::optional<BorderFault> compare_sides(const SideLine& one, const SideLine& other);

}  // namespace tintree::audit
