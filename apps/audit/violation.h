#pragma once

#include <string>

#include "codec/tile_id.h"

namespace tintree::audit {

/// A promise of the file that does not hold.
enum class ViolationKind {
  kFile,          ///< The tile is damaged or cannot be decoded.
  kMissingTile,   ///< The DEM has surface where the tree has no tile.
  kExtraTile,     ///< The tree has a tile where the DEM has no surface.
  kTopology,      ///< The mesh is no manifold.
  kCoverage,      ///< The mesh leaves out part of the surface, or covers more, or covers it twice.
  kBorder,        ///< Neighbours of one level differ along their common side.
  kBound,         ///< The tile is farther from the surface than its level allows.
  kStoredFigure,  ///< A stored figure is not what is measured.
  kHausdorff,     ///< CGAL finds a larger distance than the vertical maximum.
};

/// "bound", "coverage" and so on, as in the JSON output.
const char* kind_name(ViolationKind kind);

struct Violation {
  codec::TileId tile;
  ViolationKind kind = ViolationKind::kFile;
  std::string message;
  /// Orders violations, worst first: structural faults 1e6, else how many bounds off.
  double severity = 0;
};

inline constexpr double kStructural = 1e6;

}  // namespace tintree::audit
