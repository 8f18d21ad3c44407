#include "apps/audit/border.h"

#include <algorithm>
#include <cstdlib>

namespace tintree::audit {
namespace {

constexpr std::int64_t kEighths = 8;

void note(BorderFault& fault, const SideEdge& a, const SideEdge& b) {
  if (fault.count++ == 0) fault.position = static_cast<double>(std::max(a.begin, b.begin)) / kEighths;
  if (a.begin == b.begin) {
    fault.height_difference = std::max(fault.height_difference, std::abs(a.begin_height - b.begin_height));
  }
  if (a.end == b.end)
    fault.height_difference = std::max(fault.height_difference, std::abs(a.end_height - b.end_height));
}

}  // namespace

std::array<SideLine, 4> side_lines(const TileSurface& s) {
  std::array<SideLine, 4> lines;
  const std::int64_t far = s.across * s.units;
  const std::int64_t scale = kEighths / s.units;
  const auto put = [](SideLine& line, std::int64_t a, std::int64_t b, std::int64_t height_a, std::int64_t height_b) {
    line.push_back(a < b ? SideEdge{a, b, height_a, height_b} : SideEdge{b, a, height_b, height_a});
  };
  for (const Edge& e : s.edges) {
    if (!e.open) continue;
    const Corner& a = s.corners[e.a];
    const Corner& b = s.corners[e.b];
    if (a.x == b.x && (a.x == 0 || a.x == far)) {
      const std::int64_t origin = s.cells.row0 * kEighths;
      put(lines[a.x == 0 ? kWest : kEast], origin + a.y * scale, origin + b.y * scale, a.height, b.height);
    }
    if (a.y == b.y && (a.y == 0 || a.y == far)) {
      const std::int64_t origin = s.cells.column0 * kEighths;
      put(lines[a.y == 0 ? kNorth : kSouth], origin + a.x * scale, origin + b.x * scale, a.height, b.height);
    }
  }
  for (SideLine& line : lines) std::ranges::sort(line, {}, &SideEdge::begin);
  return lines;
}

std::optional<BorderFault> compare_sides(const SideLine& one, const SideLine& other) {
  BorderFault fault;
  auto a = one.begin();
  auto b = other.begin();
  while (a != one.end() && b != other.end()) {
    const bool overlap = std::max(a->begin, b->begin) < std::min(a->end, b->end);
    if (overlap && *a != *b) note(fault, *a, *b);
    const std::int64_t end_a = a->end;
    const std::int64_t end_b = b->end;
    if (end_a <= end_b) ++a;
    if (end_b <= end_a) ++b;
  }
  if (fault.count == 0) return std::nullopt;
  return fault;
}

}  // namespace tintree::audit
