#pragma once

#include <span>

#include "codec/error.h"
#include "render/camera.h"
#include "render/gl_functions.h"
#include "render/gpu_tile_pool.h"
#include "render/ground_style.h"
#include "render/lod_cut.h"
#include "render/shader_program.h"

namespace tintree::render {

/// Draws tiles of method `scalar` by places and indices of heights, as their payloads have them, placed as
/// ScalarPlacement tells. Lives and dies while its context is current; not thread-safe.
class ScalarDrawer {
 public:
  /// `gl` must outlive it. Fails with kIo when the driver refuses a shader.
  static Expected<ScalarDrawer> create(const GlFunctions& gl);

  /// For what is the same for all tiles of a picture.
  const ShaderProgram& program() const { return program_; }

  /// Draws the tiles of the cut that have a quantiser, with what program() has been told.
  void draw(const Camera& camera, Trees trees, std::span<const DrawTile> draws, GpuTilePool& pool, const Style& style,
            DrawStats& stats) const;

 private:
  ScalarDrawer(const GlFunctions& gl, ShaderProgram program);

  const GlFunctions* gl_;
  ShaderProgram program_;
};

}  // namespace tintree::render
