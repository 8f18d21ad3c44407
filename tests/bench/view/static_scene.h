#pragma once

#include <memory>

#include "codec/error.h"
#include "render/gpu_tile_pool.h"
#include "render/renderer.h"
#include "render/terrain_scene.h"

namespace tintree::bench {

/// All triangles of a cut, skirts too, in one buffer with one matrix, drawn by one call and the same shader: what the
/// driver can do at best.
class StaticScene {
 public:
  /// Bakes the tiles that the scene has in memory. Fails with kBadData when one is not.
  static Expected<std::unique_ptr<StaticScene>> bake(const render::GlFunctions& gl, render::TerrainScene& scene,
                                                     const render::LodCut& cut);

  render::DrawStats draw(const render::Renderer& renderer, const render::OffscreenTarget& target,
                         const render::Camera& camera);

 private:
  explicit StaticScene(const render::GlFunctions& gl);

  render::GpuTilePool pool_;
  cache::TileBounds bounds_;
  render::LodCut cut_;
};

}  // namespace tintree::bench
