#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/audit/error_histogram.h"
#include "apps/audit/error_map.h"
#include "apps/audit/tile_audit.h"
#include "apps/audit/violation.h"

namespace tintree::audit {

/// What the tiles of one level were found to be.
struct LevelReport {
  int level = 0;
  std::uint64_t tiles = 0;  ///< Present and readable.
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;  ///< Of payloads.
  double bound_m = 0;
  double vertical_max_m = 0;
  double vertical_rms_m = 0;
  /// What 99.9 % of the samples do not exceed, rounded up by at most 1/2048 of the bound.
  double vertical_p999_m = 0;
  double border_max_m = 0;
  double gap_max_m = 0;   ///< Largest distance along borders to tiles of the next coarser level.
  double gap_max_px = 0;  ///< To tiles of any coarser level, where both may meet at a pixel error of 1.
  std::uint64_t violations = 0;
  double seconds = 0;
  std::uint64_t samples = 0;      ///< Covered samples; those on the sides of tiles once a tile.
  ErrorHistogram histogram;       ///< Over these samples, against the bound.
  std::shared_ptr<ErrorMap> map;  ///< Over the whole DEM; null when none was asked for.
};

/// One tile, for the list of the worst.
struct TileFigures {
  codec::TileId id;
  double bound_m = 0;
  Peak peak;  ///< Its largest error, at DEM columns and rows.
  double rms_m = 0;
  double p999_m = 0;  ///< As LevelReport::vertical_p999_m.
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;
  double severity = 0;  ///< Of its worst violation; without one, its largest error in bounds.
};

/// CGAL's distance over a window of one tile, beside the vertical maximum over the same window.
struct HausdorffReport {
  codec::TileId tile;
  codec::CellRect cells;  ///< Of the DEM.
  double hausdorff_m = 0;
  double error_bound_m = 0;  ///< Of CGAL's result, which is at least this.
  double vertical_max_m = 0;
};

inline constexpr std::size_t kWorstTiles = 10;

struct TreeReport {
  std::vector<LevelReport> levels;
  std::vector<HausdorffReport> hausdorff;
  std::vector<Violation> violations;
  std::vector<TileFigures> worst_tiles;  ///< At most kWorstTiles, the worst first.
  double seconds = 0;
  /// Valid samples measured a second, over all levels, without CGAL's part.
  double samples_per_second = 0;

  /// The most severe violation, or null.
  const Violation* worst() const;
};

struct AuditOptions {
  int hausdorff_tiles = 3;  ///< Tiles a level that CGAL examines too; 0: none.
  int threads = 0;          ///< 0: one a core.
  int map_px = 0;           ///< Longest side of the error map of every level; 0: none.
  /// Called from any thread: (step, done, total).
  std::function<void(const std::string&, std::uint64_t, std::uint64_t)> progress;
  /// True to stop; the audit then fails with kStopped.
  std::function<bool()> stop;
};

/// Whether the tree was made from this DEM: kBadData, naming the first difference, when not.
Expected<void> match(const cache::Manifest& manifest, const cache::RasterInfo& dem);

/// Examines the file as a whole and every tile of every level, the root first and row by row, so that
/// neighbours meet. Memory: per thread a mesh and a window of 2 x 2 MiB, and the border lines of all levels but
/// the leaves', besides GDAL's block cache. Deterministic at any number of threads.
Expected<TreeReport> audit_tree(const cache::TileStore& store, const cache::RasterSource& source,
                                const AuditOptions& options);

}  // namespace tintree::audit
