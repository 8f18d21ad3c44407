#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cache/nested_shape.h"

namespace tintree::render {

using cache::BorderVertex;

/// Corner of a triangle between two tiles: a vertex of the first (`other` false) or the second.
struct StitchCorner {
  std::uint32_t vertex = 0;
  bool other = false;

  friend bool operator==(const StitchCorner&, const StitchCorner&) = default;
};

/// Triangles that fill what is open between the outlines of two tiles along a line, seen from above of no area
/// (Schneider and Westermann 2006, section 5). Both lists in ascending order, of vertices that surface joins; `other`
/// is used from one vertex before `one` to one behind it, so that neighbouring stitches overlap, and `one` no farther
/// than `other` reaches. None where a list has under two vertices, or they do not overlap.
std::vector<std::array<StitchCorner, 3>> stitch(std::span<const BorderVertex> one, std::span<const BorderVertex> other);

}  // namespace tintree::render
