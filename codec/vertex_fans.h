#pragma once

#include "codec/tile_mesh.h"

namespace tintree::codec {

/// Gives every fan of triangles round a vertex one of its own: where two parts of the surface touch in a point, between
/// holes, their vertices come apart, so that the mesh is a 2-manifold. New vertices come last. Cost: 0.1 us a triangle.
void separate_fans(TileMesh& mesh);

}  // namespace tintree::codec
