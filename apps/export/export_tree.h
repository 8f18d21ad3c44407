#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cache/tile_store.h"
#include "codec/error.h"

namespace tintree::exporter {

struct ExportOptions {
  std::string format;  ///< "ply" or "obj".
  std::string path;
  std::optional<int> level;       ///< Either this
  std::optional<double> error_m;  ///< or this.
  /// Called now and then with tiles done and in total; returns false to stop (kStopped).
  std::function<bool(std::uint64_t done, std::uint64_t total)> progress;
};

/// What was written.
struct ExportSummary {
  std::uint64_t tiles = 0;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  double error_m = 0;  ///< Largest measured error among the tiles.
};

/// Writes the tiles of a level, or the coarsest ones within an error, as one mesh. Coordinates: metres,
/// x east, y north, z up, from the DEM's upper-left sample centre. Neighbours of one level share their
/// border vertices; between levels the sides stay apart by at most the errors of both tiles. Memory: one
/// tile and the border vertices whose neighbours are still to come.
Expected<ExportSummary> export_tree(const cache::TileStore& store, const ExportOptions& options);

/// The comment lines of an exported file: the source, the frame and the way back to the CRS.
std::vector<std::string> describe(const cache::TileStore& store, const ExportOptions& options);

}  // namespace tintree::exporter
