#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "apps/audit/border.h"
#include "codec/tile_id.h"

namespace tintree::audit {

/// The lines along which the tiles of one level meet their eastern and southern neighbours, kept while finer
/// levels are compared with them. Memory: 32 bytes an edge on them, under 1/8 byte a sample even where no
/// vertex was saved.
struct LevelLines {
  int level = 0;
  int halvings = 0;  ///< TreeLayout::halvings() of the level.
  double z_step_m = 1;
  std::uint32_t tiles_x = 0;
  std::vector<SideLine> east;  ///< Row-major by tile.
  std::vector<SideLine> south;

  std::size_t index(const codec::TileId& id) const { return std::size_t{id.y} * tiles_x + id.x; }
};

/// Where two levels lie farthest apart along a line.
struct LineGap {
  double gap_m = 0;
  double position = 0;  ///< In samples along the line from the raster's corner.
};

/// The largest vertical distance between two lines where both have surface, heights in steps of `step_a_m`
/// and `step_b_m`. Both are linear between their vertices, so it lies at a vertex of one of them. Linear time.
LineGap widest_gap(const SideLine& a, double step_a_m, const SideLine& b, double step_b_m);

/// A coarse tile and the line on which it meets a finer one.
struct CoarseNeighbour {
  codec::TileId tile;
  const SideLine* line = nullptr;
};

/// The tile of the coarser level behind `side` of `fine`, for whose level the root's side is halved `halvings` times,
/// when that side lies on a line between two tiles of the coarser level.
std::optional<CoarseNeighbour> coarse_neighbour(const LevelLines& coarse, const codec::TileId& fine, int halvings,
                                                Side side);

}  // namespace tintree::audit
