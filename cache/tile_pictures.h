#pragma once

#include <cstddef>

#include "cache/tile_store.h"
#include "codec/error.h"
#include "codec/texture_codec.h"
#include "codec/tile_id.h"

namespace tintree::cache {

/// A tile's texture and normal map, ready for upload; size 0 for what it lacks.
struct TilePictures {
  codec::PixelArray colors;
  codec::PixelArray directions;  ///< Of normals.
  codec::PixelArray lengths;     ///< Of mean normals; size 0 where all are 1.

  std::size_t bytes() const { return colors.bytes.size() + directions.bytes.size() + lengths.bytes.size(); }
};

/// Reads and verifies what the tile has, be it the parent's on the same square (TreeLayout::picture_tile). `blocks`:
/// the card takes BC1; else colours are unpacked (normal maps' BC4 and BC5 every OpenGL 3.3 takes). kBadData, with the
/// file and the tile named, when something is damaged.
/// A square in a leaf has a texture only.
Expected<TilePictures> load_pictures(const TileStore& store, const codec::TileId& id, bool blocks);

}  // namespace tintree::cache
