#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/audit/tile_audit.h"
#include "apps/audit/violation.h"

namespace tintree::audit {

/// What the tiles of one level were found to be.
struct LevelReport {
  int level = 0;
  std::uint64_t tiles = 0;  ///< Present and readable.
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  double bound_m = 0;
  double vertical_max_m = 0;
  double vertical_rms_m = 0;
  double border_max_m = 0;
  std::uint64_t violations = 0;
  double seconds = 0;
  std::uint64_t samples = 0;  ///< Covered samples; those on the sides of tiles once a tile.
};

/// CGAL's distance over a window of one tile, beside the vertical maximum over the same window.
struct HausdorffReport {
  codec::TileId tile;
  codec::CellRect cells;  ///< Of the DEM.
  double hausdorff_m = 0;
  double error_bound_m = 0;  ///< Of CGAL's result, which is at least this.
  double vertical_max_m = 0;
};

struct TreeReport {
  std::vector<LevelReport> levels;
  std::vector<HausdorffReport> hausdorff;
  std::vector<Violation> violations;
  double seconds = 0;
  /// Valid samples measured a second, over all levels, without CGAL's part.
  double samples_per_second = 0;

  /// The most severe violation, or null.
  const Violation* worst() const;
};

struct AuditOptions {
  int hausdorff_tiles = 3;  ///< Tiles a level that CGAL examines too; 0: none.
  int threads = 0;          ///< 0: one a core.
  /// Called from any thread: (step, done, total).
  std::function<void(const std::string&, std::uint64_t, std::uint64_t)> progress;
  /// True to stop; the audit then fails with kStopped.
  std::function<bool()> stop;
};

/// Whether the tree was made from this DEM: kBadData, naming the first difference, when not.
Expected<void> match(const cache::Manifest& manifest, const cache::RasterInfo& dem);

/// Examines every tile of every level, the root first and row by row, so that neighbours meet and no more
/// than one row of side lines is kept. Memory: per thread a mesh and a window of 2 x 2 MiB, besides GDAL's
/// block cache. Deterministic at any number of threads.
Expected<TreeReport> audit_tree(const cache::TileStore& store, const cache::RasterSource& source,
                                const AuditOptions& options);

}  // namespace tintree::audit
