#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "cache/picture_rows.h"

namespace tintree::test {

/// Puts bytes in place of a tile's texture or normal map in a finished tree, with the checksum that belongs to them
/// and the digest that belongs to the tree. Nobody else may have the file open. Throws std::runtime_error when that
/// fails.
void replace_picture(const std::string& tree, cache::PictureKind kind, const codec::TileId& id,
                     std::span<const std::byte> bytes);

/// Takes a tile's texture away, likewise.
void remove_texture(const std::string& tree, const codec::TileId& id);

}  // namespace tintree::test
