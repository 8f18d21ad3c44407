#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cache/manifest.h"
#include "codec/error.h"
#include "codec/grid_frame.h"

namespace tintree::render {

/// A tree that is to lie in a scene.
struct TreeToPlace {
  const cache::Manifest* manifest = nullptr;
  std::string path;  ///< For messages.
};

/// Where it lies.
struct PlacedTree {
  codec::TreeLayout layout;        ///< In the scene's world frame.
  std::uint16_t joined_sides = 0;  ///< cache::SkirtSide bits: on which of its raster's sides another tree goes on.
};

/// Places several trees in one world frame, that of the first: metres east, north and up of its first sample. The
/// others lie where their georeference says; the first tree's metres hold for all, so that degrees of a geographic
/// CRS are of one size everywhere and trees cut from one raster meet exactly. A tree by itself lies as it is.
/// Fails with kBadData when a tree's CRS is not the first one's. Pure.
Expected<std::vector<PlacedTree>> place_trees(std::span<const TreeToPlace> trees);

}  // namespace tintree::render
