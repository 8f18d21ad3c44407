#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cache/nested_shape.h"

namespace tintree::cache {

/// A point of a NestedShape's hierarchy while that is made.
struct NestedShapePoint {
  using Heights = std::array<double, NestedShape::kLevels>;
  using Normal = std::array<float, 2>;

  std::int32_t x = 0;  ///< Address steps from the tile's north-west corner.
  std::int32_t y = 0;
  int level = 0;  ///< The coarsest that needs it.
  bool gap = false;
  Heights z{};                      ///< On every level's mesh, the frame's steps above its offset.
  std::array<Normal, 3> normals{};  ///< East and north, on levels 8, 7 and 6.
};

/// A shape without its borders of all points of a hierarchy, the five that are always there first. `frame`: takes
/// their places and heights to metres; `bound_steps`: the bound of the tile's level, in its height steps.
NestedShape pack_nested_shape(std::vector<NestedShapePoint> points, const codec::GridFrame& frame, std::int32_t side,
                              double bound_steps);

}  // namespace tintree::cache
