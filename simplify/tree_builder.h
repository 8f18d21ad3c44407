#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "cache/manifest.h"
#include "cache/tile_store.h"
#include "codec/error.h"
#include "codec/stop_flag.h"
#include "simplify/reference_surface.h"

namespace tintree::simplify {

/// Told of the work as it goes, from one thread at a time; returns false to stop it.
using ProgressFn = std::function<bool(const std::string& step, std::uint64_t done, std::uint64_t total)>;

/// One level of a finished tree.
struct LevelSummary {
  int level = 0;
  std::uint64_t tiles = 0;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;  ///< Payloads.
  double bound_m = 0;
  double error_m = 0;                 ///< Largest measured error of a tile.
  double rms_m = 0;                   ///< Over all its tiles' samples.
  std::uint64_t tiles_made = 0;       ///< In this run, not in one that it went on with.
  double make_seconds = 0;            ///< Spent on them by all threads together.
  std::uint64_t drawn_as_meshes = 0;  ///< Of method `strip`: those that no card unpacks.

  /// Counts a tile of a method, not its error.
  void add(const cache::StoredTile& tile, std::string_view method);
};

/// A summary for every level, of no tiles yet.
std::vector<LevelSummary> make_levels(const codec::TreeLayout& layout);

/// The height steps of every level: a quarter of its bound. Fails with kBadData when some tile's relief or some
/// height's distance from 0 is too large for the lattice at that step, and says what error would do; with kBadData too
/// when heights cannot be elevations, and with kUsage when the error itself is out of all range. Of a surface that
/// knows a part of the DEM it looks at that.
Expected<std::vector<double>> choose_height_steps(const ReferenceSurface& surface, const codec::TreeLayout& layout);

/// Makes all tiles that `writer` lacks, in depth-first Z-order, children before their parent, over all threads
/// of the current oneTBB arena, and commits each. The tiles are the same whatever the number of threads. Memory: a
/// constant number of tiles a thread. kStopped soon after `stop` is set (null: never); `writer` then holds every tile
/// that was made.
Expected<std::vector<LevelSummary>> make_tiles(const ReferenceSurface& surface, const cache::Manifest& manifest,
                                               cache::TileWriter& writer, const ProgressFn& progress,
                                               const StopFlag* stop = nullptr);

/// Decodes every tile again and measures it against the DEM in one pass over the DEM, all levels at once;
/// stores the measured errors and adds them to `levels`. kCheckFailed if a tile breaks its level's bound.
Expected<void> measure_tiles(const ReferenceSurface& surface, const cache::Manifest& manifest,
                             cache::TileWriter& writer, std::vector<LevelSummary>& levels, const ProgressFn& progress);

}  // namespace tintree::simplify
