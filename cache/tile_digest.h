#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "cache/tile_store.h"

namespace tintree::cache {

/// A tile's checksum: over its head and its payload (docs/format.md, Table tile).
std::int64_t checksum_of(const StoredTile& tile);

/// The digest of a tree, made tile by tile in ascending key order (docs/format.md, Table tile).
class TreeDigest {
 public:
  TreeDigest();
  ~TreeDigest();
  TreeDigest(const TreeDigest&) = delete;
  TreeDigest& operator=(const TreeDigest&) = delete;

  void add(const StoredTile& tile);
  /// After all tiles the textures, then the normal maps.
  void add(PictureKind kind, const codec::TileId& id, std::span<const std::byte> payload);
  /// 32 hexadecimal digits.
  std::string text() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tintree::cache
