#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "cache/nested_shape.h"

namespace tintree::cache {

/// What the tiles of a tree are made ready for drawing as.
enum class Ground {
  kMesh,    ///< Vertices and triangles; any tile can be.
  kNested,  ///< Nested levels (method `nested`).
};

/// That of a method.
inline Ground native_ground_of(std::string_view method) { return method == "nested" ? Ground::kNested : Ground::kMesh; }

/// What a tile is drawn by in place of its mesh: one of these at most. A tile of a tree of another Ground than kMesh
/// may be without, and is a mesh then.
struct NativeGround {
  std::shared_ptr<const NestedShape> nested;

  bool is_there() const { return nested != nullptr; }
  std::size_t bytes() const { return nested ? nested->bytes() : 0; }
};

}  // namespace tintree::cache
