#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "codec/grid_frame.h"
#include "codec/strip_payload.h"
#include "render/gl_functions.h"
#include "render/normal_sums.h"
#include "render/shader_program.h"

namespace tintree::render {

/// Normals for strips, which have none in their words: made on the card from the words, the same mean of a vertex's
/// triangles as cache::make_drawable() takes, and drawn from above into a small normal map. Lives and dies while its
/// context is current; not thread-safe.
class StripNormals {
 public:
  /// `gl` must outlive it. Fails with kIo when the driver refuses a shader.
  static Expected<std::unique_ptr<StripNormals>> create(const GlFunctions& gl);
  ~StripNormals();
  StripNormals(const StripNormals&) = delete;
  StripNormals& operator=(const StripNormals&) = delete;

  /// What make() takes of the graphics memory for good: 4 bytes a texel, a half to two texels a triangle. While it
  /// works 16 bytes for each of the tile's places more.
  static std::size_t bytes(const codec::StripHead& head);
  /// East and north of unit normals, RG16F, the outer texels on the tile's sides, from triangles `vertex_array` has as
  /// indices from `first_word` on. `frame`: of their places and heights. The texture is the caller's. The framebuffer
  /// that is bound and the viewport stay as they are.
  GLuint make(const codec::StripHead& head, const codec::GridFrame& frame, GLuint vertex_array,
              std::uint32_t first_word) const;

 private:
  StripNormals(const GlFunctions& gl, NormalSums sums, ShaderProgram normals);
  void draw_into(GLuint texture, int texels, GLuint vertex_array) const;

  const GlFunctions* gl_;
  NormalSums sums_;
  ShaderProgram normals_;
  GLuint framebuffer_ = 0;
};

}  // namespace tintree::render
