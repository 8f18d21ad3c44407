#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cache/manifest.h"
#include "cache/tile_store.h"
#include "codec/error.h"
#include "codec/grid_frame.h"
#include "codec/mesh_codec.h"
#include "codec/stop_flag.h"
#include "codec/tile_mesh.h"
#include "simplify/collapse_spec.h"
#include "simplify/reference_surface.h"

namespace tintree::simplify {

/// Reads tiles that others build on.
using TileReader = std::function<Expected<cache::StoredTile>(const codec::TileId&)>;

/// Makes tiles: the geometry half of a method (its codec is the other). A tile is a pure function of the DEM's
/// samples in and next to its square, so tiles can be made in any order, on any thread, again after a crash.
/// One maker serves one thread.
class TileMaker {
 public:
  virtual ~TileMaker() = default;

  /// A mesh over the existing surface in the tile's square, within the level's bound of it everywhere; without
  /// triangles when there is no surface. Fails with kBadData when the heights do not fit the lattice, and with
  /// what the DEM's reader says, and with kStopped soon after a stop was asked for, even inside a tile.
  virtual Expected<codec::TileMesh> make(const codec::TileId& id) = 0;

  /// The payload of a mesh that make() has returned: what the method's codec makes of it, unless the method needs more
  /// than the mesh.
  virtual Expected<std::vector<std::byte>> encode(const codec::MeshCodec& codec, const codec::TileId& /*id*/,
                                                  const codec::TileMesh& mesh) {
    return codec.encode(mesh);
  }

  /// For a tile that is made for its figures alone: the next encode() of it takes cheap stand-ins for the tiles above,
  /// and its decoder may read them by what this returns; null for methods whose tiles need no others.
  virtual Expected<TileReader> stand_in_above(const codec::TileId& /*id*/) { return TileReader{}; }
};

/// The methods that make_tile_maker() knows, the default one first.
std::vector<std::string> method_names();

/// A maker of the tiles that the manifest describes, by its layout, method and the method's own choices; null for a
/// method that this version lacks. `stop` must outlive it.
std::unique_ptr<TileMaker> make_tile_maker(const cache::Manifest& manifest, const ReferenceSurface& surface,
                                           const StopFlag* stop = nullptr);

}  // namespace tintree::simplify
