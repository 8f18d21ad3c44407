#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "cache/height_blocks.h"
#include "cache/manifest.h"
#include "codec/error.h"
#include "codec/stop_flag.h"
#include "codec/tile_id.h"

namespace tintree::simplify {

/// A tile that was made for its figures and thrown away.
struct SampledTile {
  codec::TileId id;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;  ///< Of the payload; 0 where there is no surface.
  double make_seconds = 0;  ///< Processor time.
  double load_seconds = 0;  ///< The same for loading its window to measure; leaves only.
  double measure_seconds = 0;
};

/// The sample of one level.
struct LevelSample {
  int level = 0;
  std::uint64_t tiles = 0;          ///< Squares of the level that hold cells.
  std::int64_t cells = 0;           ///< DEM cells in them.
  std::int64_t sampled_cells = 0;   ///< Those under the sample.
  std::vector<SampledTile> sample;  ///< Empty where even one tile would cost too much.
};

/// Which tiles to sample: per level, spread evenly along the space-filling curve, as many as cover a twentieth of
/// the DEM, but at least 24 leaves or their area and at most 100 tiles. None of the upper levels where one tile is much
/// more than that.
std::vector<LevelSample> choose_sample(const codec::TreeLayout& layout);

/// Makes a sample of the tree's tiles in memory, over all threads of the current oneTBB arena, and times it.
/// `manifest` needs neither digest nor height steps. Fails as choose_height_steps() for what it sees of the DEM;
/// kStopped soon after `stop` is set.
Expected<std::vector<LevelSample>> sample_tiles(const std::shared_ptr<cache::HeightBlocks>& blocks,
                                                cache::Manifest manifest, const StopFlag* stop);

}  // namespace tintree::simplify
