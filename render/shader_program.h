#pragma once

#include <string_view>

#include "codec/error.h"
#include "render/gl_functions.h"

namespace tintree::render {

/// A linked program of two of the embedded shaders. Lives and dies while its context is current.
class ShaderProgram {
 public:
  /// `gl` must outlive it. Fails with kIo and the driver's words when it refuses a shader.
  static Expected<ShaderProgram> create(const GlFunctions& gl, std::string_view vertex_name,
                                        std::string_view fragment_name);

  ShaderProgram(ShaderProgram&& other) noexcept;
  ShaderProgram& operator=(ShaderProgram&&) = delete;
  ~ShaderProgram();

  void use() const { gl_->UseProgram(id_); }
  /// -1, which OpenGL ignores, for a name that the program does not use.
  GLint uniform(const char* name) const { return gl_->GetUniformLocation(id_, name); }

 private:
  ShaderProgram(const GlFunctions& gl, GLuint id) : gl_(&gl), id_(id) {}

  const GlFunctions* gl_;
  GLuint id_ = 0;
};

}  // namespace tintree::render
