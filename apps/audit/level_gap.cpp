#include "apps/audit/level_gap.h"

#include <algorithm>
#include <cmath>

namespace tintree::audit {
namespace {

constexpr double kEighths = 8;

double height_m(const SideEdge& e, std::int64_t position, double step_m) {
  const double share = static_cast<double>(position - e.begin) / static_cast<double>(e.end - e.begin);
  const auto begin = static_cast<double>(e.begin_height);
  return (begin + share * (static_cast<double>(e.end_height) - begin)) * step_m;
}

}  // namespace

LineGap widest_gap(const SideLine& a, double step_a_m, const SideLine& b, double step_b_m) {
  LineGap widest;
  // The finer line is usually the shorter one: begin where it begins.
  auto i = a.begin();
  auto j = b.begin();
  if (i != a.end() && j != b.end()) {
    const auto ends_before = [](const SideEdge& e, std::int64_t position) { return e.end < position; };
    i = std::lower_bound(i, a.end(), j->begin, ends_before);
    if (i != a.end()) j = std::lower_bound(j, b.end(), i->begin, ends_before);
  }
  while (i != a.end() && j != b.end()) {
    const std::int64_t from = std::max(i->begin, j->begin);
    const std::int64_t to = std::min(i->end, j->end);
    if (from < to) {
      for (const std::int64_t at : {from, to}) {
        const double gap = std::abs(height_m(*i, at, step_a_m) - height_m(*j, at, step_b_m));
        if (gap > widest.gap_m) widest = {gap, static_cast<double>(at) / kEighths};
      }
    }
    const std::int64_t end_a = i->end;
    const std::int64_t end_b = j->end;
    if (end_a <= end_b) ++i;
    if (end_b <= end_a) ++j;
  }
  return widest;
}

std::optional<CoarseNeighbour> coarse_neighbour(const LevelLines& coarse, const codec::TileId& fine, int halvings,
                                                Side side) {
  const auto depth = static_cast<std::uint32_t>(halvings - coarse.halvings);
  const std::uint32_t mask = (1U << depth) - 1;
  const bool across = side == kWest || side == kEast;
  const bool towards_origin = side == kWest || side == kNorth;
  const std::uint32_t place = across ? fine.x : fine.y;
  // Fine tiles that begin, or end, where a coarse one does.
  if ((place & mask) != (towards_origin ? 0 : mask)) return std::nullopt;
  const codec::TileId own{coarse.level, fine.x >> depth, fine.y >> depth};
  codec::TileId other = own;
  std::uint32_t& moved = across ? other.x : other.y;
  if (towards_origin && moved == 0) return std::nullopt;
  moved = towards_origin ? moved - 1 : moved + 1;
  const std::vector<SideLine>& lines = across ? coarse.east : coarse.south;
  const std::size_t count = lines.size() / coarse.tiles_x;
  if (other.x >= coarse.tiles_x || other.y >= count) return std::nullopt;
  return CoarseNeighbour{other, &lines[coarse.index(towards_origin ? other : own)]};
}

}  // namespace tintree::audit
