#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cache/occluder.h"
#include "cache/tile_bounds.h"
#include "cache/tile_ref.h"
#include "render/camera.h"

namespace tintree::render {

struct CutOptions {
  /// Tiles are refined until their error projects to at most this many pixels. 0 draws the leaves.
  double pixel_error = 1;
  /// Tiles with a texture are refined, too, until the side of its texels projects to at most this many pixels: flat
  /// ground has next to no error and yet a photo on it.
  double texel_px = 1;
  bool morph = false;  ///< Weigh each tile's way to its parent (render/morph.h); else DrawTile::morph stays 0.
  /// What tiles are drawn off their own meshes, and so off their boxes and occluders: vertically by no more than so
  /// many pixels measure across the view at their distance (render/nested_lod.h).
  double off_px = 0;

  bool operator==(const CutOptions&) const = default;
};

/// A square in a leaf, of a grid with `1 << depth` squares a side, that has a finer texture of its own.
struct TexturePart {
  int depth = 0;
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  codec::TileId texture;
};

/// One tile of a cut.
struct DrawTile {
  std::uint32_t tree = 0;  ///< Which of the scene's trees,
  std::uint32_t node = 0;  ///< and which of its TileBounds::nodes().
  double error_px = 0;     ///< Its projected error; infinite when the eye is inside its box.
  double nearest_m = 0;    ///< Bounds of the depth of its visible part.
  double farthest_m = 0;
  bool stands_in = false;  ///< Drawn because what should be drawn here is not resident.
  double morph = 0;        ///< Share of the way to the parent's surface at which to draw it.
  int nested_level = 8;    ///< Of a tile with nested levels, the one to draw it by (render/nested_lod.h).
  /// Of a leaf with finer textures (render/texture_parts.h): those of LodCut::parts,
  std::uint32_t first_part = 0;
  std::uint32_t parts = 0;
  int part_row = -1;  ///< and which of the leaves that have some it is; -1 for none.
};

/// Which tiles to draw for a view, and which to fetch.
struct LodCut {
  CutOptions options;              ///< That it was chosen by.
  std::vector<DrawTile> draws;     ///< Tree by tree, the nearest first; in each front to back, no two overlapping.
  std::vector<TexturePart> parts;  ///< Of its leaves, and of each the coarser ones first.
  /// Missing tiles, the most important on the screen first: the coarsest, then those nearest to the view's middle.
  std::vector<cache::TileRef> requests;
  double max_error_px = 0;         ///< The largest error_px drawn.
  bool complete = true;            ///< Every tile that the view wants is resident and drawn.
  std::uint32_t leaf_limited = 0;  ///< Leaves drawn above pixel_error: the data end there.
  std::uint32_t wanted = 0;        ///< Tiles that the view would draw with everything resident.
  std::uint32_t late = 0;          ///< Those of them that are not resident yet.
  std::uint32_t culled = 0;        ///< Nodes at which the walk ended because the frustum does not reach them.
  std::uint32_t occluded = 0;      ///< Nodes at which it ended because nearer ground hides them.
  double nearest_m = 0;            ///< Bounds of the depth of what is drawn; both 0 when nothing is.
  double farthest_m = 0;
};

/// Bounding-box hierarchies in one world frame.
using Trees = std::span<const cache::TileBounds* const>;

/// What is known of a node's tile.
enum class TileState {
  kMissing,
  kResident,  ///< It can be drawn at once.
  kLost,      ///< It will never come: its bytes are damaged.
};
using TileStates = std::function<TileState(std::uint32_t tree, std::uint32_t node)>;
/// The same of one tree of which nothing is lost: whether the tile can be drawn at once.
using IsResident = std::function<bool(std::uint32_t node)>;

/// The occluder of a resident node's tile; null when it has none.
using OccluderOf = std::function<const cache::Occluder*(std::uint32_t tree, std::uint32_t node)>;

/// Walks the bounding-box hierarchy front to back (Wahl et al. 2004, section 5, Quadtree Update). A node
/// outside the frustum ends there; one whose error (ScreenError::bound_px) is at most pixel_error, or that has no
/// children, is taken; any other is refined. Where a wanted tile is missing, its finest drawable ancestor
/// stands in for all that it covers, or finer resident tiles that cover it do, so that the ground never has
/// a hole once the root is resident. With everything resident the cut depends on the camera alone.
/// Only where a tile is lost with all that could stand in for it does the ground have a hole for good.
/// With `occluder_of` a node that the ground drawn before it hides ends there too and is not asked for
/// (render/occlusion.h): the picture is the same, to the last pixel. A tree's ground hides that tree's tiles only.
/// Pure: keeps nothing, changes nothing. Cost: about 0.3 us a node visited; with occlusion a microsecond, and a few
/// more a tile drawn.
LodCut lod_cut(Trees trees, const Camera& camera, const CutOptions& options, const TileStates& states,
               const OccluderOf& occluder_of = nullptr);
LodCut lod_cut(const cache::TileBounds& bounds, const Camera& camera, const CutOptions& options,
               const IsResident& resident, const OccluderOf& occluder_of = nullptr);

}  // namespace tintree::render
