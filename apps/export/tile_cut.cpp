#include "apps/export/tile_cut.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include <fmt/format.h>

namespace tintree::exporter {
namespace {

class Descent {
 public:
  Descent(const cache::TileStore& store, double error_m)
      : store_(store), nodes_(store.bounds().nodes()), error_m_(error_m) {}

  /// Adds the cut below a node to tiles(); returns the least error with which that would have worked.
  Expected<double> visit(std::size_t at) {
    const cache::TileNode& node = nodes_[at];
    const auto tile = store_.read(node.id);
    if (!tile) return tl::unexpected(tile.error());
    if (tile->info.error_m <= error_m_) {
      tiles_.push_back(node.id);
      return tile->info.error_m;
    }
    const auto children = static_cast<std::size_t>(std::popcount(node.child_mask));
    double needed = 0;
    for (std::size_t i = 0; i < children; ++i) {
      const auto below = visit(node.first_child + i);
      if (!below) return below;
      needed = std::max(needed, *below);
    }
    return children == 0 ? tile->info.error_m : std::min(needed, tile->info.error_m);
  }

  const std::vector<codec::TileId>& tiles() const { return tiles_; }

 private:
  const cache::TileStore& store_;
  std::span<const cache::TileNode> nodes_;
  double error_m_;
  std::vector<codec::TileId> tiles_;
};

/// The least number of few digits that is not below `value`.
double rounded_up(double value) {
  const double step = std::pow(10.0, std::floor(std::log10(value)) - 5);
  return std::ceil(value / step) * step;
}

}  // namespace

Expected<std::vector<codec::TileId>> tiles_of_level(const cache::TileStore& store, int level) {
  const int leaf_level = store.manifest().layout.leaf_level;
  if (level < 0 || level > leaf_level) {
    return fail(ErrorCode::kUsage, fmt::format("there is no level {}; this tree has levels 0 to {}", level, leaf_level),
                "--level");
  }
  std::vector<codec::TileId> tiles;
  for (const cache::TileNode& node : store.bounds().nodes()) {
    if (node.id.level == level) tiles.push_back(node.id);
  }
  return tiles;
}

Expected<std::vector<codec::TileId>> tiles_within(const cache::TileStore& store, double error_m) {
  Descent descent(store, error_m);
  const auto needed = descent.visit(0);
  if (!needed) return tl::unexpected(needed.error());
  if (*needed > error_m) {
    return fail(
        ErrorCode::kUsage,
        fmt::format("no tiles are within {:g} m everywhere; the smallest error that this tree can give is {:.6g} m",
                    error_m, rounded_up(*needed)),
        "--error");
  }
  return descent.tiles();
}

}  // namespace tintree::exporter
