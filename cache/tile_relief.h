#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/grid_frame.h"
#include "codec/patch_residual.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::cache {

/// What a graphics card lights a tile of method `wavelet` by: all samples of the tile's patch, however few vertices its
/// mesh has (Yusov & Turlapov 2008: normals from the reconstructed heights). The card makes the heights from the
/// parent's, which must be there, and the residual; and the normals, at the tile's (cells + 1)^2 nodes, from those.
struct TileRelief {
  codec::PatchResidual residual;
  std::optional<codec::TileId> parent;  ///< Without one the prediction is 0.
  bool has_children = false;
  int quadrant = 0;  ///< Of the parent's square: bit 0 east, bit 1 south.
  /// The patch's samples that lie on the raster: the first column and row, the last ones.
  std::array<int, 4> on_raster{};
  /// For a tile with holes, per sample of the patch, whether there is surface; else empty.
  std::vector<std::uint8_t> surface;
  /// How far north-west of the patch's own sample i the tile's node i lies, spacings: 0 for leaves, up to a half.
  float node_shift = 0;
  /// Takes height units a spacing along columns and along rows to slopes east and north, column-major 2x2.
  std::array<float, 4> slopes{};

  std::size_t bytes() const { return sizeof *this + residual.bytes() + surface.size(); }
};

/// `mesh` is the tile's, and has passed validate(). Cost: about 0.1 ms, with holes 1 ms.
TileRelief make_tile_relief(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh,
                            codec::PatchResidual residual);

}  // namespace tintree::cache
