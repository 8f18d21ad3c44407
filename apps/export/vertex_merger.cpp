#include "apps/export/vertex_merger.h"

#include <bit>

namespace tintree::exporter {
namespace {

constexpr double kEighths = 8;

std::uint64_t mixed(std::uint64_t v) {
  v *= 0x9e3779b97f4a7c15ULL;
  return v ^ (v >> 32);
}

}  // namespace

std::size_t VertexMerger::Hash::operator()(const Place& p) const {
  std::uint64_t h = mixed(static_cast<std::uint64_t>(p.column));
  h = mixed(h ^ static_cast<std::uint64_t>(p.row));
  return mixed(h ^ std::bit_cast<std::uint64_t>(p.height_m));
}

std::optional<std::uint32_t> VertexMerger::merge(const codec::TileId& tile, const codec::GridFrame& frame,
                                                 const codec::GridVertex& vertex, std::uint32_t number) {
  const auto column = static_cast<std::int64_t>(frame.column(vertex.x) * kEighths);
  const auto row = static_cast<std::int64_t>(frame.row(vertex.y) * kEighths);
  const std::int64_t across = layout_.cells_across(tile.level) * static_cast<std::int64_t>(kEighths);
  const bool on_column = column % across == 0;
  const bool on_row = row % across == 0;
  if (!on_column && !on_row) return std::nullopt;
  const Place place{column, row, frame.height_m(vertex.z)};
  const int others = on_column && on_row ? 3 : 1;
  const auto [at, added] = places_.try_emplace(place, Entry{number, others, tile.key()});
  if (added) return std::nullopt;
  Entry& entry = at->second;
  const std::uint32_t found = entry.number;
  if (entry.last_tile != tile.key()) {
    entry.last_tile = tile.key();
    if (--entry.tiles_to_come == 0) places_.erase(at);
  }
  return found;
}

}  // namespace tintree::exporter
