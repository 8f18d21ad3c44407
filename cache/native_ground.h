#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "cache/nested_shape.h"
#include "cache/strip_shape.h"

namespace tintree::cache {

/// What the tiles of a tree are made ready for drawing as.
enum class Ground {
  kMesh,    ///< Vertices and triangles; any tile can be.
  kNested,  ///< Nested levels (method `nested`).
  kStrip,   ///< A strip that the card unpacks (method `strip`).
};

/// That of a method.
inline Ground native_ground_of(std::string_view method) {
  if (method == "nested") return Ground::kNested;
  return method == "strip" ? Ground::kStrip : Ground::kMesh;
}

/// What a tile is drawn by in place of its mesh: one of these at most. A tile of a tree of another Ground than kMesh
/// may be without, and is a mesh then.
struct NativeGround {
  std::shared_ptr<const NestedShape> nested;
  std::shared_ptr<const StripShape> strip;  ///< With it the tile has no arrays of a mesh.

  bool is_there() const { return nested != nullptr || strip != nullptr; }
  std::size_t bytes() const { return (nested ? nested->bytes() : 0) + (strip ? strip->bytes() : 0); }
};

}  // namespace tintree::cache
