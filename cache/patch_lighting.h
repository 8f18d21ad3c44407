#pragma once

#include "cache/manifest.h"

namespace tintree::cache {

/// Whether a tree's tiles are lit by their patches: where those keep to a largest error, as the meshes do. A patch that
/// keeps only to an RMS of the same bound may miss what the mesh has; and stored normals are the DEM's own.
inline bool lit_by_patches(const Manifest& manifest) {
  return manifest.method == "wavelet" && manifest.criterion == "max" && !manifest.normal_maps;
}

}  // namespace tintree::cache
