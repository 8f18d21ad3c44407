#pragma once

#include <cstdint>

#include "codec/error.h"
#include "codec/strip_payload.h"
#include "codec/strip_tree.h"
#include "codec/tile_mesh.h"

namespace tintree::codec {

/// A mesh made ready to be written as a strip.
struct StripSource {
  StripTree tree;
  StripHead head;
  std::int32_t lowest = 0;  ///< z of the lowest vertex.

  /// The height that stands for a vertex in the payload.
  std::uint32_t code(const SplitPoint& v) const {
    const std::int32_t z = tree.z(v);
    return z < 0 ? head.missing() : static_cast<std::uint32_t>(z - lowest) >> head.z_shift;
  }
  /// Calls `visit` with every triangle of the path.
  template <typename Visit>
  void walk(const Visit& visit) const {
    walk_strip(
        std::int64_t{1} << head.levels, [this](const SplitPoint& at) { return tree.is_split(at); }, visit);
  }
};

/// Fails with kBadData on what is no restricted quadtree mesh, or is too fine for a strip.
Expected<StripSource> find_strip(const TileMesh& mesh);

/// The edge from v1 to v2.
StripEdge edge_between(const SplitPoint& v1, const SplitPoint& v2);

}  // namespace tintree::codec
