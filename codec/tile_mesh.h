#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/error.h"
#include "codec/height_quantizer.h"
#include "codec/scalar_shape.h"

namespace tintree::codec {

/// A vertex on its tile's grid. `x` counts address steps eastward and `y` southward from the tile's
/// north-west corner, `z` counts height steps upward from the tile's height origin (0 to 2^22 - 1).
struct GridVertex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend bool operator==(const GridVertex&, const GridVertex&) = default;
};

/// Three vertex indices, counter-clockwise seen from above (x east, y north).
using Triangle = std::array<std::uint32_t, 3>;

/// A place where a nested mesh is split although no surface is there, and the level that does so first.
struct NestedGap {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::uint8_t level = 0;

  friend bool operator==(const NestedGap&, const NestedGap&) = default;
};

/// One tile's triangulated irregular network on its local integer grid: exactly what is stored, and
/// all that a codec has to carry. GridFrame turns it into metres.
struct TileMesh {
  int xy_shift = 0;           ///< One address step is 2^xy_shift DEM samples (-3 to 29).
  std::int64_t z_offset = 0;  ///< Height origin, in the level's height steps.
  std::vector<GridVertex> vertices;
  std::vector<Triangle> triangles;
  /// Method `nested` alone (codec/nested_tile.h): which of its levels, 0 the coarsest, first has each vertex;
  /// for those at the end that repeat others (split_fans()), nothing.
  std::vector<std::uint8_t> nested_levels{};
  std::vector<NestedGap> nested_gaps{};
  /// Method `scalar` alone: what grids the vertices belong to.
  std::optional<ScalarShape> scalar_shape{};
  /// Of the heights inside such a tile, where it has been decoded and there are any. Encoders find their own.
  std::optional<HeightQuantizer> height_quantizer{};
};

/// Limits of the format; readers refuse what exceeds them before they allocate for it.
inline constexpr int kMinXyShift = -3;
inline constexpr int kMaxXyShift = 29;
inline constexpr std::int32_t kMaxHeightAddress = (1 << 22) - 1;
inline constexpr std::int64_t kMaxHeightOffset = std::int64_t{1} << 52;  ///< Either way.
inline constexpr std::size_t kMaxTileVertices = std::size_t{1} << 26;
inline constexpr std::size_t kMaxTileTriangles = std::size_t{1} << 27;

/// Checks every index and address of `mesh` for a tile that spans `cells` DEM cells a side: indices
/// exist, x and y lie inside the tile, z in 0..2^22 - 1, z_offset within the limit, every triangle has positive area
/// seen from above. What decoded bytes must pass before anything else touches them.
Expected<void> validate(const TileMesh& mesh, std::int64_t cells);

/// Twice the signed area of a triangle in the plane, in address steps squared; positive when it is
/// counter-clockwise seen from above.
inline std::int64_t doubled_area(const GridVertex& a, const GridVertex& b, const GridVertex& c) {
  // y runs southward, so the usual cross product changes sign.
  return std::int64_t{c.x - a.x} * (b.y - a.y) - std::int64_t{b.x - a.x} * (c.y - a.y);
}

}  // namespace tintree::codec
