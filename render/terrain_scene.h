#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <unordered_set>
#include <vector>

#include "cache/tile_cache.h"
#include "cache/tile_store.h"
#include "codec/error.h"
#include "render/camera.h"
#include "render/gl_functions.h"
#include "render/gpu_tile_pool.h"
#include "render/lod_cut.h"
#include "render/offscreen_target.h"
#include "render/renderer.h"

namespace tintree::render {

struct SceneOptions {
  CutOptions cut;
  std::size_t cache_bytes = std::size_t{256} << 20;  ///< Main memory for tiles made ready.
  std::size_t gpu_bytes = std::size_t{512} << 20;    ///< Graphics memory for tiles.
  /// The most that update() uploads at once, so that a frame stays short; it uploads one tile at least.
  std::size_t upload_bytes = std::numeric_limits<std::size_t>::max();
};

/// What the last update() or settle() did for its frame, beside the cut.
struct FrameStats {
  std::uint32_t cache_hits = 0;    ///< Tiles that came to be missing on the graphics card and were ready in memory.
  std::uint32_t cache_misses = 0;  ///< Those that had to be read first; each counts once until it has come.
  std::uint32_t uploads = 0;       ///< Tiles moved to the graphics card.
  std::size_t upload_bytes = 0;
  std::uint64_t bytes_read = 0;  ///< Payload bytes read by the caching thread since the frame before.
  std::size_t cache_bytes = 0;   ///< Main memory held by tiles made ready.
  std::size_t gpu_bytes = 0;     ///< Graphics memory held by tiles.
};

/// One tree as a scene: for each camera it chooses the cut, takes over what the caching thread has made
/// ready, asks it for what is missing, and draws. Lives and dies while its context is current; to be used by
/// that context's thread only.
class TerrainScene {
 public:
  /// `gl` and `store` must outlive it. Fails with kIo when the driver refuses a shader.
  static Expected<std::unique_ptr<TerrainScene>> create(const GlFunctions& gl, const cache::TileStore& store,
                                                        const SceneOptions& options);

  /// Chooses what to draw for this camera now. Never waits.
  LodCut update(const Camera& camera);
  /// The same once all tiles of the cut are there. Fails with a tile's error when one cannot be loaded.
  Expected<LodCut> settle(const Camera& camera);
  DrawStats draw(const OffscreenTarget& target, const Camera& camera, const LodCut& cut, const Style& style);

  const FrameStats& frame_stats() const { return stats_; }
  /// What has failed since the last call: each tile once.
  std::vector<Error> take_errors() { return cache_.take_errors(); }

  const cache::TileBounds& bounds() const { return store_->bounds(); }
  const Renderer& renderer() const { return renderer_; }
  cache::TileCache& cache() { return cache_; }
  const GpuTilePool& pool() const { return pool_; }
  CutOptions& cut_options() { return options_.cut; }

 private:
  TerrainScene(const GlFunctions& gl, const cache::TileStore& store, const SceneOptions& options, Renderer renderer);
  LodCut choose(const Camera& camera);
  LodCut advance(const Camera& camera);
  /// Moves tiles that have come to the graphics card; what is still missing is left in `wanted`. Returns
  /// how many it moved.
  std::size_t take_over(std::vector<codec::TileId>& wanted);

  const cache::TileStore* store_;
  SceneOptions options_;
  cache::TileCache cache_;
  GpuTilePool pool_;
  Renderer renderer_;
  FrameStats stats_;
  std::uint64_t bytes_read_before_ = 0;
  std::unordered_set<std::int64_t> awaited_;  ///< Keys of the tiles that were missing and have been counted.
};

}  // namespace tintree::render
