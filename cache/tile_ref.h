#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "codec/tile_id.h"

namespace tintree::cache {

/// A tile of one of several trees.
struct TileRef {
  codec::TileId id;
  std::uint32_t tree = 0;

  friend bool operator==(const TileRef&, const TileRef&) = default;
};

struct TileRefHash {
  std::size_t operator()(const TileRef& t) const {
    return std::hash<std::int64_t>()(t.id.key() ^ static_cast<std::int64_t>(t.tree) << 40);
  }
};

}  // namespace tintree::cache
