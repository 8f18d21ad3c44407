#include "render/shader_program.h"

#include <array>
#include <string>
#include <utility>

#include "render/shader_sources.h"

namespace tintree::render {
namespace {

using Log = std::array<char, 2048>;

Expected<GLuint> compile(const GlFunctions& gl, const ShaderStage& stage) {
  const std::array sources{stage.version, shader_source(stage.shared), shader_source(stage.name)};
  std::array<const char*, sources.size()> texts{};
  std::array<GLint, sources.size()> lengths{};
  for (std::size_t i = 0; i < sources.size(); ++i) {
    texts[i] = sources[i].empty() ? "" : sources[i].data();
    lengths[i] = static_cast<GLint>(sources[i].size());
  }
  const GLuint shader = gl.CreateShader(stage.kind);
  gl.ShaderSource(shader, static_cast<GLsizei>(sources.size()), texts.data(), lengths.data());
  gl.CompileShader(shader);
  GLint done = GL_FALSE;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done == GL_TRUE) return shader;
  Log log{};
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  gl.DeleteShader(shader);
  return fail(ErrorCode::kIo, std::string("the driver refuses the shader: ") + log.data(), std::string(stage.name));
}

}  // namespace

Expected<ShaderProgram> ShaderProgram::create(const GlFunctions& gl, std::string_view vertex_name,
                                              std::string_view fragment_name) {
  return link(gl,
              std::array{ShaderStage{GL_VERTEX_SHADER, vertex_name}, ShaderStage{GL_FRAGMENT_SHADER, fragment_name}});
}

Expected<ShaderProgram> ShaderProgram::link(const GlFunctions& gl, std::span<const ShaderStage> stages,
                                            const char* feedback) {
  ShaderProgram program(gl, gl.CreateProgram());
  for (const ShaderStage& stage : stages) {
    const auto shader = compile(gl, stage);
    if (!shader) return tl::unexpected(shader.error());
    gl.AttachShader(program.id_, *shader);
    gl.DeleteShader(*shader);  // with the program
  }
  if (feedback != nullptr) gl.TransformFeedbackVaryings(program.id_, 1, &feedback, GL_INTERLEAVED_ATTRIBS);
  gl.LinkProgram(program.id_);
  GLint done = GL_FALSE;
  gl.GetProgramiv(program.id_, GL_LINK_STATUS, &done);
  if (done == GL_TRUE) return program;
  Log log{};
  gl.GetProgramInfoLog(program.id_, static_cast<GLsizei>(log.size()), nullptr, log.data());
  return fail(ErrorCode::kIo, std::string("the driver cannot link the shader: ") + log.data(),
              std::string(stages.front().name));
}

ShaderProgram::ShaderProgram(ShaderProgram&& other) noexcept : gl_(other.gl_), id_(std::exchange(other.id_, 0)) {}

ShaderProgram::~ShaderProgram() {
  if (id_ != 0) gl_->DeleteProgram(id_);
}

}  // namespace tintree::render
