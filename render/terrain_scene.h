#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include "cache/tile_cache.h"
#include "cache/tile_store.h"
#include "codec/error.h"
#include "render/camera.h"
#include "render/far_picture.h"
#include "render/gl_functions.h"
#include "render/gpu_tile_pool.h"
#include "render/lod_cut.h"
#include "render/occlusion.h"
#include "render/offscreen_target.h"
#include "render/prefetch.h"
#include "render/renderer.h"
#include "render/texture_parts.h"
#include "render/tree_placement.h"

namespace tintree::render {

struct SceneOptions {
  CutOptions cut;  ///< `morph` is chosen here once: the tiles are made for it.
  Occlusion occlusion = Occlusion::kWhereItPays;
  bool impostors = false;  ///< Far ground as a picture that holds for several frames (render/impostor.h).
  std::size_t cache_bytes = std::size_t{256} << 20;  ///< Main memory for tiles made ready.
  /// Graphics memory for tiles, and for the impostors' picture, never exceeded: a view that needs more is drawn without
  /// impostors from then on, and coarser where its tiles do not fit.
  std::size_t gpu_bytes = std::size_t{512} << 20;
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
  std::size_t gpu_bytes = 0;     ///< Graphics memory held by tiles and the impostors' picture.
  bool gpu_memory_full = false;  ///< The view needs more than that may be: parts of it are drawn coarser.
};

/// One or several trees as a scene: for each camera it chooses the cut, takes over what the caching thread has
/// made ready, asks it for what is missing, and draws. Never reads or decodes itself. Lives and dies while its context
/// is current; to be used by that context's thread only.
class TerrainScene {
 public:
  using Stores = std::span<const cache::TileStore* const>;

  /// `gl` and the stores must outlive it. The first tree's world frame is the scene's (place_trees). Fails with
  /// kIo when the driver refuses a shader, with kBadData when the trees do not go together.
  static Expected<std::unique_ptr<TerrainScene>> create(const GlFunctions& gl, Stores stores,
                                                        const SceneOptions& options);
  static Expected<std::unique_ptr<TerrainScene>> create(const GlFunctions& gl, const cache::TileStore& store,
                                                        const SceneOptions& options);

  /// Chooses what to draw for this camera now. Never waits. With `seconds`, the time of this frame by any clock, what
  /// the camera's way so far leads to is loaded ahead.
  LodCut update(const Camera& camera, std::optional<double> seconds = std::nullopt);
  /// The same once all tiles of the cut are there that can be: lost tiles are stood in for (take_errors() names them),
  /// and so is what exceeds the graphics memory. Fails with a tile's error when nothing can be drawn for one.
  Expected<LodCut> settle(const Camera& camera);
  DrawStats draw(const OffscreenTarget& target, const Camera& camera, const LodCut& cut, const Style& style);

  const FrameStats& frame_stats() const { return stats_; }
  /// What has failed since the last call, each failure once (TileCache::take_errors).
  std::vector<Error> take_errors() { return cache_->take_errors(); }
  /// Whether the view could become more complete without moving: tiles are on their way or wait for their upload.
  bool busy(const LodCut& cut);

  /// The trees' bounding-box hierarchies in the scene's world frame.
  Trees trees() const { return trees_; }
  /// The first tree's.
  const cache::TileBounds& bounds() const { return *trees_.front(); }
  const Renderer& renderer() const { return renderer_; }
  cache::TileCache& cache() { return *cache_; }
  const GpuTilePool& pool() const { return pool_; }
  CutOptions& cut_options() { return options_.cut; }
  Occlusion& occlusion() { return options_.occlusion; }

 private:
  TerrainScene(const GlFunctions& gl, Stores stores, std::span<const PlacedTree> places, const SceneOptions& options,
               Renderer renderer, GpuMakers makers, std::unique_ptr<FarPicture> far_picture);
  LodCut advance(const Camera& camera, std::optional<double> seconds);
  TileState state(std::uint32_t tree, std::uint32_t node);
  TextureState fine_texture(const cache::TileRef& square);
  /// Whether it names a texture on a square in a leaf.
  bool is_fine_texture(const cache::TileRef& ref) const { return ref.id.level > trees_[ref.tree]->layout().leaf_level; }
  /// Moves tiles that have come to the graphics card; what is still missing is left in `wanted`. Returns
  /// how many it moved.
  std::size_t take_over(std::vector<cache::TileRef>& wanted);
  /// Sees to it that what a tile's relief is made of is on the card before it; false while that is to be waited for,
  /// and then it is in `missing`.
  bool bring_parent(const cache::TileRef& ref, const cache::DrawableTile& tile, std::vector<cache::TileRef>& missing);
  void count_misses(std::span<const cache::TileRef> missing);
  /// What to load ahead, as seen from where the camera is going.
  std::vector<cache::TileRef> tiles_ahead(const Camera& camera, double seconds);
  /// Returns what the next impostor lacks. Where impostors and what the view needs do not fit into the graphics memory
  /// together there are none any more.
  std::vector<cache::TileRef> plan_far_picture(const Camera& camera);
  void give_up_far_picture();
  void sum_up();

  SceneOptions options_;
  /// Of all trees but the first, which lies where its store says, unless its errors are raised.
  std::vector<cache::TileBounds> placed_;
  std::vector<std::uint8_t> nested_;  ///< 1 for trees that are drawn by their nested levels.
  std::vector<const cache::TileBounds*> trees_;
  std::unique_ptr<cache::TileCache> cache_;
  GpuTilePool pool_;
  Renderer renderer_;
  std::unique_ptr<FarPicture> far_picture_;  ///< Null without impostors, or room for them.
  bool far_picture_lacks_ = false;           ///< Tiles of the next one are on their way.
  CameraTrail trail_;
  OcclusionSwitch occlusion_pays_;
  FrameStats stats_;
  std::uint64_t bytes_read_before_ = 0;
  std::unordered_set<cache::TileRef, cache::TileRefHash> awaited_;  ///< Missing tiles that have been counted.
  bool pool_full_ = false;                                          ///< In this frame.
};

}  // namespace tintree::render
