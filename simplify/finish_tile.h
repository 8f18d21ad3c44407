#pragma once

#include <cstdint>

#include "codec/error.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::simplify {

/// Brings a tile's mesh onto the coarsest address grid that holds it. Its vertices come in steps of 2^-sub_bits
/// samples, the tile being `span` steps wide, and their heights in the level's steps above mesh.z_offset, of either
/// sign. Fails with kBadData when the heights do not fit the format.
Expected<codec::TileMesh> finish_tile(codec::TileMesh mesh, std::int64_t span, int sub_bits, const codec::TileId& id);

}  // namespace tintree::simplify
