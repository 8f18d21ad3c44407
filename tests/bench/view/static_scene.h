#pragma once

#include <memory>
#include <vector>

#include "codec/error.h"
#include "render/gpu_tile_pool.h"
#include "render/renderer.h"
#include "render/terrain_scene.h"

namespace tintree::bench {

/// What a cut draws from one static buffer, by the same shader: what the driver can do at best. All its triangles,
/// skirts too, lie there with one matrix and are drawn by one call; but where tiles have pictures, each is drawn by a
/// call of its own, because a call has one picture, and so has its own matrix.
class StaticScene {
 public:
  /// Bakes the tiles that the scene has in memory, with their textures. Fails with kBadData when one is not, or is no
  /// mesh. The scene must outlive it.
  static Expected<std::unique_ptr<StaticScene>> bake(const render::GlFunctions& gl, render::TerrainScene& scene,
                                                     const render::LodCut& cut);

  render::DrawStats draw(const render::Renderer& renderer, const render::OffscreenTarget& target,
                         const render::Camera& camera);

 private:
  StaticScene(const render::GlFunctions& gl, render::TerrainScene& scene, const render::LodCut& cut);
  Expected<std::shared_ptr<const cache::DrawableTile>> tile_of(const cache::TileRef& ref) const;
  Expected<void> bake_as_one();
  Expected<void> bake_tile_by_tile();

  render::TerrainScene& scene_;
  render::GpuTilePool pool_;
  cache::TileBounds whole_;  ///< The one tile that all are made into.
  std::vector<const cache::TileBounds*> trees_;
  render::LodCut cut_;
};

}  // namespace tintree::bench
