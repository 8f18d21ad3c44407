#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <utility>

#include "codec/tile_id.h"

namespace tintree::codec {

/// The patches that were used last, reconstructed (Patch) or with their bytes (EncodedPatch). In Z-order a tile finds
/// all that are above it. Not thread-safe.
template <typename T>
class PatchCache {
 public:
  /// Null when it is not here.
  std::shared_ptr<const T> find(const TileId& id) {
    for (auto at = entries_.begin(); at != entries_.end(); ++at) {
      if (at->first != id) continue;
      entries_.splice(entries_.begin(), entries_, at);
      return at->second;
    }
    return nullptr;
  }
  void keep(const TileId& id, std::shared_ptr<const T> patch) {
    entries_.emplace_front(id, std::move(patch));
    if (entries_.size() > kPatches) entries_.pop_back();
  }

 private:
  static constexpr std::size_t kPatches = 24;  // of half a MiB each at 256 cells

  std::list<std::pair<TileId, std::shared_ptr<const T>>> entries_;
};

}  // namespace tintree::codec
