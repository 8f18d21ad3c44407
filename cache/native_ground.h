#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "cache/nested_shape.h"
#include "cache/quantized_shape.h"
#include "cache/strip_shape.h"

namespace tintree::cache {

/// What the tiles of a tree are made ready for drawing as.
enum class Ground {
  kMesh,    ///< Vertices and triangles; any tile can be.
  kNested,  ///< Nested levels (method `nested`).
  kStrip,   ///< A strip that the card unpacks (method `strip`).
  kScalar,  ///< Vertices with indices of heights, dequantised by the card (method `scalar`).
};

/// That of a method.
inline Ground native_ground_of(std::string_view method) {
  if (method == "nested") return Ground::kNested;
  if (method == "scalar") return Ground::kScalar;
  return method == "strip" ? Ground::kStrip : Ground::kMesh;
}

/// What a tile is drawn by in place of its mesh: one of these at most. A tile of a tree of another Ground than kMesh
/// may be without, and is a mesh then.
struct NativeGround {
  std::shared_ptr<const NestedShape> nested;
  std::shared_ptr<const StripShape> strip;       ///< With it the tile has no arrays of a mesh.
  std::shared_ptr<const QuantizedShape> scalar;  ///< With it the tile has a mesh's indices, but no DrawVertex.

  bool is_there() const { return nested != nullptr || strip != nullptr || scalar != nullptr; }
  std::size_t bytes() const {
    return (nested ? nested->bytes() : 0) + (strip ? strip->bytes() : 0) + (scalar ? scalar->bytes() : 0);
  }
};

}  // namespace tintree::cache
