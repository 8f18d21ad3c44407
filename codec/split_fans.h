#pragma once

#include "codec/tile_mesh.h"

namespace tintree::codec {

/// Gives every fan of triangles a vertex of its own: where several meet at one point only, as beside holes that touch,
/// its vertex is repeated. Deterministic; linear in the triangles.
void split_fans(TileMesh& mesh);

}  // namespace tintree::codec
