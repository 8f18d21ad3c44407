#include "render/shader_program.h"

#include <array>
#include <string>
#include <utility>

#include "render/shader_sources.h"

namespace tintree::render {
namespace {

using Log = std::array<char, 2048>;

Expected<GLuint> compile(const GlFunctions& gl, GLenum kind, std::string_view name) {
  const std::string_view source = shader_source(name);
  const GLuint shader = gl.CreateShader(kind);
  const char* text = source.data();
  const auto length = static_cast<GLint>(source.size());
  gl.ShaderSource(shader, 1, &text, &length);
  gl.CompileShader(shader);
  GLint done = GL_FALSE;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done == GL_TRUE) return shader;
  Log log{};
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  gl.DeleteShader(shader);
  return fail(ErrorCode::kIo, std::string("the driver refuses the shader: ") + log.data(), std::string(name));
}

}  // namespace

Expected<ShaderProgram> ShaderProgram::create(const GlFunctions& gl, std::string_view vertex_name,
                                              std::string_view fragment_name) {
  const auto vertex = compile(gl, GL_VERTEX_SHADER, vertex_name);
  if (!vertex) return tl::unexpected(vertex.error());
  const auto fragment = compile(gl, GL_FRAGMENT_SHADER, fragment_name);
  if (!fragment) {
    gl.DeleteShader(*vertex);
    return tl::unexpected(fragment.error());
  }
  ShaderProgram program(gl, gl.CreateProgram());
  gl.AttachShader(program.id_, *vertex);
  gl.AttachShader(program.id_, *fragment);
  gl.LinkProgram(program.id_);
  gl.DeleteShader(*vertex);
  gl.DeleteShader(*fragment);
  GLint done = GL_FALSE;
  gl.GetProgramiv(program.id_, GL_LINK_STATUS, &done);
  if (done == GL_TRUE) return program;
  Log log{};
  gl.GetProgramInfoLog(program.id_, static_cast<GLsizei>(log.size()), nullptr, log.data());
  return fail(ErrorCode::kIo, std::string("the driver cannot link the shader: ") + log.data(),
              std::string(vertex_name));
}

ShaderProgram::ShaderProgram(ShaderProgram&& other) noexcept : gl_(other.gl_), id_(std::exchange(other.id_, 0)) {}

ShaderProgram::~ShaderProgram() {
  if (id_ != 0) gl_->DeleteProgram(id_);
}

}  // namespace tintree::render
