#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/error.h"
#include "codec/grid_frame.h"
#include "codec/tile_id.h"

namespace tintree::cache {

/// What is known of a tile without its mesh.
struct TileInfo {
  codec::TileId id;
  std::uint32_t vertices = 0;
  std::uint32_t triangles = 0;
  double z_min_m = 0;  ///< Range of the mesh's heights.
  double z_max_m = 0;
  double error_m = 0;         ///< Measured: largest vertical distance to the DEM's surface.
  double rms_m = 0;           ///< Measured: root mean square over the samples.
  double border_error_m = 0;  ///< Measured: the largest along the tile's four sides.

  /// The error by which a viewer chooses levels: a gap between two levels is then under one pixel too.
  double lod_error_m() const { return error_m > 2 * border_error_m ? error_m : 2 * border_error_m; }
};

/// An axis-aligned box in the world frame, metres.
struct Box {
  std::array<double, 3> min{};
  std::array<double, 3> max{};
};

/// One tile of the hierarchy. Children lie at first_child, in Z-order, those missing left out.
struct TileNode {
  codec::TileId id;
  float z_min_m = 0;              ///< Lowest point of this tile and of all tiles below it, rounded down.
  float z_max_m = 0;              ///< Highest point of the same, rounded up.
  float lod_error_m = 0;          ///< Rounded up.
  std::uint8_t child_mask = 0;    ///< Bit i: child i (TreeLayout::child) exists.
  std::uint32_t first_child = 0;  ///< Index into nodes(); meaningless when child_mask is 0.
};

/// The bounding-box hierarchy of a whole tree: 16 bytes a tile on disk, readable without any payload.
/// Immutable and thus safe to share between threads.
class TileBounds {
 public:
  TileBounds() = default;
  /// `tiles` in ascending key order, every tile's parent among them.
  TileBounds(const codec::TreeLayout& layout, std::span<const TileInfo> tiles);

  /// Takes the bound of its level for every tile's error. Then which tile of a place is fine enough does not depend on
  /// how well others happen to keep their bounds: what nested levels need that are to morph into the next tile's.
  void raise_errors();
  /// The same tiles, lying elsewhere.
  TileBounds placed(const codec::TreeLayout& layout) const;

  std::vector<std::byte> to_bytes() const;
  /// Fails with kBadData when the bytes describe no tree over `layout`.
  static Expected<TileBounds> from_bytes(const codec::TreeLayout& layout, std::span<const std::byte> bytes);

  /// All tiles in key order; the root is the first.
  std::span<const TileNode> nodes() const { return nodes_; }
  /// Index of a tile's node, or -1.
  std::int64_t find(const codec::TileId& id) const;
  /// The upright box round the tile: its cells of the raster times the height range of it and of all tiles below it.
  Box box(const TileNode& node) const;
  const codec::TreeLayout& layout() const { return layout_; }
  /// Side of the texels of a tile of `level`, metres; 0 in a tree without textures.
  double texel_m(int level) const {
    return leaf_texel_m_ * static_cast<double>(layout_.cells_across(level) / layout_.tile_cells);
  }
  /// How often leaves are halved for finer textures.
  int texture_depth() const { return texture_depth_; }
  /// The tree's tiles have textures of so many texels a side, and leaves halved up to `depth` times finer ones.
  void set_textures(int texels, int depth) {
    leaf_texel_m_ = std::max(layout_.dx_m, layout_.dy_m) * layout_.tile_cells / texels;
    texture_depth_ = depth;
  }

 private:
  void link_children();

  codec::TreeLayout layout_;
  double leaf_texel_m_ = 0;
  int texture_depth_ = 0;
  std::vector<TileNode> nodes_;
};

}  // namespace tintree::cache
