#pragma once

#include <span>
#include <string_view>

#include "codec/error.h"
#include "render/gl_functions.h"

namespace tintree::render {

/// One of a program's shaders: an embedded file, behind another that it shares with others and a first line, if given.
struct ShaderStage {
  GLenum kind = GL_VERTEX_SHADER;
  std::string_view name;
  std::string_view shared = {};
  std::string_view version = {};
};

/// A linked program of some of the embedded shaders. Lives and dies while its context is current.
class ShaderProgram {
 public:
  /// `gl` must outlive it. Fails with kIo and the driver's words when it refuses a shader.
  static Expected<ShaderProgram> create(const GlFunctions& gl, std::string_view vertex_name,
                                        std::string_view fragment_name);

  /// Of any stages; `feedback` names the output that transform feedback takes, if there is one.
  static Expected<ShaderProgram> link(const GlFunctions& gl, std::span<const ShaderStage> stages,
                                      const char* feedback = nullptr);

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
