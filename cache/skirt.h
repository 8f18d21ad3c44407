#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "cache/drawable_tile.h"
#include "codec/tile_mesh.h"

namespace tintree::cache {

/// Hangs a skirt on every edge of `mesh` that lies on a side behind which the ground goes on: two triangles each behind
/// `indices`. `lower(vertex, sides)` makes the foot below a vertex, once for each, and returns its number; `sides`:
/// SkirtSide bits of those that the vertex lies on.
template <typename Lower>
void add_skirts(const codec::TileMesh& mesh, const TileOutline& outline, const Lower& lower,
                std::vector<std::uint32_t>& indices) {
  std::unordered_map<std::uint32_t, std::uint32_t> feet;
  const auto sides = [&](std::uint32_t i) {
    const codec::GridVertex& v = mesh.vertices[i];
    const int on = (v.x == 0 ? kSkirtWest : 0) | (v.x == outline.east ? kSkirtEast : 0) | (v.y == 0 ? kSkirtNorth : 0) |
                   (v.y == outline.south ? kSkirtSouth : 0);
    return static_cast<std::uint16_t>(on & outline.sides);
  };
  const auto foot = [&](std::uint32_t i) {
    const auto [at, added] = feet.try_emplace(i, 0);
    if (added) at->second = lower(i, sides(i));
    return at->second;
  };
  for (const codec::Triangle& t : mesh.triangles) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t a = t[corner];
      const std::uint32_t b = t[(corner + 1) % 3];
      if ((sides(a) & sides(b)) == 0) continue;
      const std::uint32_t foot_a = foot(a);
      const std::uint32_t foot_b = foot(b);
      for (const std::uint32_t i : {b, a, foot_a, b, foot_a, foot_b}) indices.push_back(i);
    }
  }
}

}  // namespace tintree::cache
