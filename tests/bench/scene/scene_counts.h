#pragma once

#include <cstdint>
#include <vector>

#include "cache/tile_store.h"
#include "codec/error.h"
#include "render/camera.h"
#include "tests/bench/scene/error_ladder.h"

namespace tintree::bench {

/// Triangles of one view at one pixel of error. From `drawn` on each is what the one before would be without one of
/// the things that a tree of tiles costs; the differences between neighbours say what each costs.
struct SceneCounts {
  std::uint64_t tiles = 0;
  double max_error_px = 0;   ///< Of the tiles drawn.
  double full = 0;           ///< Of the full-resolution surface, within the picture.
  double drawn = 0;          ///< Of the tiles drawn, whole as they are.
  double in_picture = 0;     ///< The same, within the picture alone.
  double one_tile = 0;       ///< Of meshes without tile borders, best effort, at each tile's level's bound.
  double any_error = 0;      ///< At the error that would be a pixel in each tile's box: no steps of two.
  double fewest = 0;         ///< At the error that is a pixel at the place itself: no tiles. The lower bound.
  double fewest_level = 0;   ///< The same if a vertical metre counted everywhere as it does where it counts most.
  double beyond_ladder = 0;  ///< Share of `fewest` that was extrapolated.
};

/// A tree and the ladder of the same ground. Keeps both; one thread.
class SceneCounter {
 public:
  static Expected<SceneCounter> open(const cache::TileStore& store, const ErrorLadder& ladder);

  /// Errors are never asked below the leaves' bound: the tree has nothing finer.
  Expected<SceneCounts> count(const render::Camera& camera) const;

 private:
  SceneCounter(const cache::TileStore& store, const ErrorLadder& ladder) : store_(store), ladder_(ladder) {}

  const cache::TileStore& store_;
  const ErrorLadder& ladder_;
  std::vector<GroundBlocks> levels_;      ///< The tree's own triangles, by level.
  std::vector<std::uint32_t> triangles_;  ///< Of each node.
};

/// `views` cameras of a flight over the tree's ground from its north-west to its south-east corner, turning its gaze
/// between 20 and 70 degrees below the horizon, from the height where the leaves' bound projects to a pixel to
/// twice that.
std::vector<render::Camera> flight(const cache::TileBounds& bounds, int views);

}  // namespace tintree::bench
