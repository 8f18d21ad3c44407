#pragma once

#include <array>
#include <utility>

#include "codec/grid_frame.h"
#include "render/gl_functions.h"
#include "render/shader_program.h"

namespace tintree::render {

/// While it lives another framebuffer may be bound; then the one of before is again, with its viewport.
class TargetGuard {
 public:
  explicit TargetGuard(const GlFunctions& gl) : gl_(&gl) {
    gl.GetIntegerv(GL_FRAMEBUFFER_BINDING, &framebuffer_);
    gl.GetIntegerv(GL_VIEWPORT, viewport_.data());
  }
  TargetGuard(const TargetGuard&) = delete;
  TargetGuard& operator=(const TargetGuard&) = delete;
  ~TargetGuard() {
    gl_->BindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(framebuffer_));
    gl_->Viewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  }

 private:
  const GlFunctions* gl_;
  GLint framebuffer_ = 0;
  std::array<GLint, 4> viewport_{};
};

/// Sums of triangles' normals at a tile's places, with the weights of cache::make_drawable(), made on the card. Lives
/// and dies while its context is current; not thread-safe.
class NormalSums {
 public:
  /// `vertex` puts out `address`, a vertex's place and height. `gl` must outlive it. Fails with kIo when the driver
  /// refuses a shader.
  static Expected<NormalSums> create(const GlFunctions& gl, const ShaderStage& vertex);
  NormalSums(NormalSums&& other) noexcept;
  NormalSums& operator=(NormalSums&&) = delete;
  ~NormalSums();

  /// To be told, in use, what the vertex shader needs, before make().
  const ShaderProgram& program() const { return program_; }

  /// A square texture with a texel a place, RGBA32F, `places` across, bound to unit 0; the caller's. `frame`: of the
  /// addresses, whose heights count 2^z_shift height steps. `draw` draws the triangles. To be called while a
  /// TargetGuard lives.
  template <typename Draw>
  GLuint make(const codec::GridFrame& frame, int z_shift, int places, const Draw& draw) const {
    const GLuint out = begin(frame, z_shift, places);
    draw();
    end();
    return out;
  }

 private:
  NormalSums(const GlFunctions& gl, ShaderProgram program);
  GLuint begin(const codec::GridFrame& frame, int z_shift, int places) const;
  void end() const;

  const GlFunctions* gl_;
  ShaderProgram program_;
  GLuint framebuffer_ = 0;
};

}  // namespace tintree::render
