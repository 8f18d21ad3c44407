#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "apps/audit/level_gap.h"
#include "apps/audit/tile_audit.h"
#include "apps/audit/tree_audit.h"

namespace tintree::audit {

/// Walks one level of a tree and sums up what is found. Tiles are examined in parallel and accounted for
/// in row-major order.
class LevelWalk {
 public:
  /// `coarser`: the lines of all coarser levels. `skip` tells the tiles known to be empty because their parents
  /// are. `map_px`: longest side of the error map, 0 for none.
  LevelWalk(const AuditContext& context, int level, const std::vector<LevelLines>& coarser,
            std::function<bool(const codec::TileId&)> skip, int map_px);

  /// Adds the level's violations and its tiles, when they are among the worst, to the report.
  Expected<LevelReport> run(TreeReport& tree);
  /// The level's own lines, once it has been walked; empty for the leaves, which no level is compared with.
  LevelLines take_lines() { return std::move(lines_); }
  /// Row-major flags of the level's tiles without surface.
  const std::vector<bool>& empty() const { return empty_; }

 private:
  codec::TileId tile_at(std::uint64_t index) const;
  void account(TileReport& tile, TreeReport& tree);
  void compare_borders(TileReport& tile);
  void compare_levels(TileReport& tile);
  void compare_level(TileReport& tile, Side side, const LevelLines& coarse);
  void keep_lines(TileReport& tile);
  double lod_error_m(const codec::TileId& id) const;
  void compare_border(TileReport& tile, Side side, const codec::TileId& neighbour, const SideLine& line);

  const AuditContext& context_;
  LevelReport report_;
  std::uint32_t tiles_x_;
  std::uint32_t tiles_y_;
  double z_step_m_;
  std::function<bool(const codec::TileId&)> skip_;
  const std::vector<LevelLines>& coarser_;
  double sum_squares_m2_ = 0;
  std::vector<bool> empty_;
  SideLine east_;                ///< East side of the tile before in the row.
  std::vector<SideLine> south_;  ///< South sides of the row before, overwritten from the west.
  LevelLines lines_;
};

}  // namespace tintree::audit
