#pragma once

#include <array>
#include <functional>
#include <vector>

#include "apps/audit/border.h"
#include "apps/audit/error_histogram.h"
#include "apps/audit/error_map.h"
#include "apps/audit/vertical_distance.h"
#include "apps/audit/violation.h"
#include "cache/raster_source.h"
#include "cache/tile_store.h"

namespace tintree::audit {

/// What every tile's examination needs. All of it may be used from several threads.
struct AuditContext {
  const cache::TileStore& store;
  const cache::RasterSource& source;
  /// Told of the DEM cells just examined; returns false to stop.
  std::function<bool(std::int64_t cells)> advance;
};

/// What one tile was found to be.
struct TileReport {
  codec::TileId id;
  bool present = false;  ///< The tree has the tile and it could be decoded.
  bool empty = false;    ///< The DEM has no surface here, and the tree no tile.
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;  ///< Of the payload.
  VerticalDistance distance;
  ErrorHistogram histogram;  ///< Over the samples, against the level's bound.
  std::array<SideLine, 4> sides;
  std::vector<Violation> violations;
};

/// What every part of an audit says when it was stopped.
Error stopped_error();

/// Examines one tile of the tree's grid, there or not: file, topology, coverage, vertical distance, and the
/// figures stored with it. What is wrong with the tile becomes violations; an error means that the audit
/// itself could not go on (kIo, kStopped). Large tiles are measured window by window on all cores, with
/// memory for the mesh and one window a thread. `map`: also takes the errors in; may be null.
Expected<TileReport> audit_tile(const AuditContext& context, const codec::TileId& id, ErrorMap* map = nullptr);

/// The largest difference by which a stored figure may miss the measured one: rounding only.
double figure_tolerance(double measured);

}  // namespace tintree::audit
