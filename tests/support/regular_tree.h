#pragma once

#include <string>
#include <vector>

#include "cache/raster_source.h"
#include "cache/tile_store.h"
#include "tests/support/test_raster.h"

namespace tintree::test {

/// How to make a tree of regular meshes.
struct RegularTreeOptions {
  int tile_cells = 16;
  int levels_per_doubling = 1;  ///< With 2, tiles on the same square have the same mesh.
  /// Leaf bound; 0 takes the smallest that all levels keep.
  double leaf_error_m = 0;
  double z_step_m = 1.0 / 256;
  /// Tiles twice as wide take every second sample. On a raster with holes, and without this,
  /// all levels hold every sample.
  bool coarsen = true;
  /// Address steps of leaf tiles: 2^xy_shift samples, 0 to -3.
  int xy_shift = 0;
};

/// A whole tree in memory, made without simplify/ and open to damage before it is written.
struct TestTree {
  cache::Manifest manifest;
  std::vector<cache::StoredTile> tiles;  ///< In key order.

  cache::StoredTile& tile(const codec::TileId& id);
  codec::TileMesh mesh(const codec::TileId& id) const;
  /// Encodes `mesh` into the tile; its figures stay as they are.
  void set_mesh(const codec::TileId& id, const codec::TileMesh& mesh);
};

/// A valid tree over the raster, every figure measured by naive_figures().
TestTree make_regular_tree(const cache::RasterSource& source, const RegularTreeOptions& options = {});
TestTree make_regular_tree(const std::string& raster, const RegularTreeOptions& options = {});

/// Writes the tree through TileWriter; throws std::runtime_error when that fails.
void write_tree(const std::string& path, const TestTree& tree);

}  // namespace tintree::test
