#pragma once

#include <vector>

#include "cache/tile_store.h"
#include "codec/error.h"
#include "codec/grid_frame.h"
#include "codec/mesh_codec.h"
#include "codec/tile_id.h"
#include "simplify/tile_maker.h"

namespace tintree::simplify {

/// All tiles that hold cells of the raster, depth-first, children before their parent.
std::vector<codec::TileId> list_tiles(const codec::TreeLayout& layout);

/// Makes and encodes one tile, ready to be stored; it is not measured yet. Its payload is empty where there is no
/// surface.
Expected<cache::StoredTile> make_stored_tile(TileMaker& maker, const codec::MeshCodec& codec,
                                             const codec::TreeLayout& layout, const codec::TileId& id);

}  // namespace tintree::simplify
