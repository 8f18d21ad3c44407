#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "codec/error.h"
#include "codec/tile_mesh.h"

namespace tintree::codec {

/// A guess of the surface's height at sample (x, y) of the tile, in quarters of the tile's height step.
using HeightGuess = std::function<std::int64_t(std::int64_t x, std::int64_t y)>;

/// A tile's triangles where they are right triangles over samples: 16 x 16 squares, or one a cell, cut by diagonals of
/// alternating direction, and split at the middle of the longest side wherever a bit says so (Evans et al. 2001;
/// the quadtree triangulation of Yusov & Turlapov 2008). Where both halves of a cell of the DEM are triangles, they
/// have the surface's own diagonal. A split needs those that make its own triangles, so most bits need no saying; the
/// others and the heights go through an adaptive range coder, by what the guess and the corners around let expect.
/// Integers only. Cost: about 0.3 us a vertex either way. `cells`: DEM cells along the tile's side, a power of two.

/// kUsage for a mesh of another kind.
Expected<std::vector<std::byte>> encode_right_triangles(const TileMesh& mesh, std::int64_t cells,
                                                        const HeightGuess& guess);
/// The same triangles on the coarsest grid that holds them, heights from the lowest one, fans apart (split_fans).
/// kBadData for no such code.
Expected<TileMesh> decode_right_triangles(std::span<const std::byte> bytes, std::int64_t cells,
                                          const HeightGuess& guess);

}  // namespace tintree::codec
