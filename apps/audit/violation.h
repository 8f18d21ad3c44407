#pragma once

#include <optional>
#include <string>

#include "codec/tile_id.h"

namespace tintree::audit {

/// A promise of the file that does not hold.
enum class ViolationKind {
  kFile,          ///< The tile is damaged or cannot be decoded, or the table of tiles is not what it should be.
  kManifest,      ///< A digest in the manifest is not that of the tiles, or not that of the DEM.
  kHierarchy,     ///< A box of the hierarchy does not hold its tile, or reaches out of its parent's.
  kMissingTile,   ///< The DEM has surface where the tree has no tile.
  kExtraTile,     ///< The tree has a tile where the DEM has no surface.
  kTopology,      ///< The mesh is no manifold.
  kCoverage,      ///< The mesh leaves out part of the surface, or covers more, or covers it twice.
  kBorder,        ///< Neighbours of one level differ along their common side.
  kGap,           ///< Neighbours of two levels are farther apart than a pixel where they may meet.
  kBound,         ///< The tile is farther from the surface than its level allows.
  kStoredFigure,  ///< A stored figure is not what is measured.
  kHausdorff,     ///< CGAL finds a larger distance than the vertical maximum.
  kPicture,       ///< A texture or normal map is damaged, missing, or lies or shows wrong.
  kImage,         ///< A picture drawn from the tree is not that of the surface within a pixel.
};

/// "bound", "coverage" and so on, as in the JSON output.
const char* kind_name(ViolationKind kind);

struct Violation {
  std::optional<codec::TileId> tile;  ///< None: the file as a whole.
  ViolationKind kind = ViolationKind::kFile;
  std::string message;
  /// Orders violations, worst first: structural faults 1e6, else how many bounds off.
  double severity = 0;

  /// "tile 3/1/2: message" or "file: message".
  std::string text() const;
};

inline constexpr double kStructural = 1e6;

}  // namespace tintree::audit
