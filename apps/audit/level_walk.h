#pragma once

#include <functional>
#include <vector>

#include "apps/audit/tile_audit.h"
#include "apps/audit/tree_audit.h"

namespace tintree::audit {

/// Walks one level of a tree and sums up what is found. Tiles are examined in parallel and accounted for
/// in row-major order.
class LevelWalk {
 public:
  /// `skip` tells the tiles known to be empty because their parents are.
  LevelWalk(const AuditContext& context, int level, std::function<bool(const codec::TileId&)> skip);

  Expected<LevelReport> run(std::vector<Violation>& violations);
  /// Row-major flags of the level's tiles without surface.
  const std::vector<bool>& empty() const { return empty_; }

 private:
  codec::TileId tile_at(std::uint64_t index) const;
  void account(TileReport& tile);
  void compare_borders(TileReport& tile);
  void compare_border(TileReport& tile, Side side, const codec::TileId& neighbour, const SideLine& line);

  const AuditContext& context_;
  LevelReport report_;
  std::uint32_t tiles_x_;
  std::uint32_t tiles_y_;
  double z_step_m_;
  std::function<bool(const codec::TileId&)> skip_;
  double sum_squares_m2_ = 0;
  std::vector<bool> empty_;
  SideLine east_;                ///< East side of the tile before in the row.
  std::vector<SideLine> south_;  ///< South sides of the row before, overwritten from the west.
};

}  // namespace tintree::audit
