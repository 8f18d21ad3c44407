#pragma once

#include <cstddef>
#include <memory>

#include "cache/tile_relief.h"
#include "codec/patch_residual.h"
#include "render/gl_functions.h"
#include "render/shader_program.h"

namespace tintree::render {

/// A tile's cache::TileRelief on the card.
struct GpuRelief {
  GLuint heights = 0;  ///< Of its patch, while there are children to predict from it: R32I, the patch's size.
  /// East and north of unit normals at the tile's nodes: RG16F, one texel a node; 0 for no relief.
  GLuint normals = 0;
  std::size_t bytes = 0;
};

inline void destroy(const GlFunctions& gl, const GpuRelief& relief) {
  gl.DeleteTextures(1, &relief.heights);
  gl.DeleteTextures(1, &relief.normals);
}

/// Makes wavelet tiles' patches and normals on the graphics card (Yusov & Turlapov 2008, section 4): prediction plus
/// residual in integers, bit for bit what the processor decodes; normals by central differences. Fragment shaders into
/// textures, which OpenGL 3.3 can. The framebuffer that is bound and the viewport stay as they are. Lives and dies
/// while its context is current; not thread-safe.
class PatchReconstructor {
 public:
  /// `gl` must outlive it. Fails with kIo when the driver refuses a shader.
  static Expected<std::unique_ptr<PatchReconstructor>> create(const GlFunctions& gl);
  ~PatchReconstructor();
  PatchReconstructor(const PatchReconstructor&) = delete;
  PatchReconstructor& operator=(const PatchReconstructor&) = delete;

  /// What make() takes of the graphics memory for good; while it works, as much again at most.
  static std::size_t bytes(const cache::TileRelief& relief);
  /// `parent_heights`: of the parent's GpuRelief. Without them a tile that has a parent has no relief.
  GpuRelief make(const cache::TileRelief& relief, GLuint parent_heights) const;

  /// The two steps: textures that are the caller's.
  GLuint make_heights(const cache::TileRelief& relief, GLuint parent_heights) const;
  GLuint make_normals(const cache::TileRelief& relief, GLuint heights) const;

 private:
  PatchReconstructor(const GlFunctions& gl, ShaderProgram heights, ShaderProgram normals);
  void fill(GLuint texture, int size) const;

  const GlFunctions* gl_;
  ShaderProgram heights_;
  ShaderProgram normals_;
  GLuint framebuffer_ = 0;
  GLuint no_vertices_ = 0;
};

}  // namespace tintree::render
