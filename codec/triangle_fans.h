#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/tile_mesh.h"

namespace tintree::codec {

/// Orders triangles into fans: the vertices of each, the hub first, then `restart`. `hubs` names vertices in the order
/// in which they take what triangles are left round them; together they must reach all triangles. Every triangle keeps
/// its orientation. Linear cost.
std::vector<std::uint32_t> triangle_fans(std::span<const Triangle> triangles, std::span<const std::uint32_t> hubs,
                                         std::size_t vertices, std::uint32_t restart);

}  // namespace tintree::codec
