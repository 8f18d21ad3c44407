#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>

#include "codec/grid_frame.h"
#include "codec/tile_id.h"

namespace tintree::exporter {

/// Finds the vertices that neighbouring tiles share: those at one place on the sides of their tiles.
/// An entry goes when all tiles of its level that can share it have come, so that memory grows with the
/// front of the tiles visited, not with their number.
class VertexMerger {
 public:
  explicit VertexMerger(const codec::TreeLayout& layout) : layout_(layout) {}

  /// The number of a vertex met before at this place, or nothing; then `number` stands for it from now on.
  /// Vertices inside their tile are never shared.
  std::optional<std::uint32_t> merge(const codec::TileId& tile, const codec::GridFrame& frame,
                                     const codec::GridVertex& vertex, std::uint32_t number);

 private:
  /// A position, exact: eighths of samples, and the height's bits.
  struct Place {
    std::int64_t column;
    std::int64_t row;
    double height_m;
    friend bool operator==(const Place&, const Place&) = default;
  };
  struct Hash {
    std::size_t operator()(const Place& p) const;
  };
  struct Entry {
    std::uint32_t number;
    int tiles_to_come;
    std::int64_t last_tile;  // a tile may hold a place twice, where holes touch
  };

  codec::TreeLayout layout_;
  std::unordered_map<Place, Entry, Hash> places_;
};

}  // namespace tintree::exporter
