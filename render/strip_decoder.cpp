#include "render/strip_decoder.h"

#include <array>
#include <cstring>
#include <span>
#include <utility>

namespace tintree::render {
namespace {

/// A buffer that shaders read as 32-bit texels, while it lives.
class TexelBuffer {
 public:
  TexelBuffer(const GlFunctions& gl, std::span<const std::byte> bytes, int unit) : gl_(&gl) {
    // Shaders may look one texel past the end.
    std::vector<std::uint32_t> texels(bytes.size() / 4 + 2);
    std::memcpy(texels.data(), bytes.data(), bytes.size());
    gl.GenBuffers(1, &buffer_);
    gl.BindBuffer(GL_TEXTURE_BUFFER, buffer_);
    gl.BufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(4 * texels.size()), texels.data(), GL_STREAM_DRAW);
    gl.GenTextures(1, &texture_);
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl.BindTexture(GL_TEXTURE_BUFFER, texture_);
    gl.TexBuffer(GL_TEXTURE_BUFFER, GL_R32UI, buffer_);
  }
  TexelBuffer(const TexelBuffer&) = delete;
  TexelBuffer& operator=(const TexelBuffer&) = delete;
  ~TexelBuffer() {
    gl_->DeleteTextures(1, &texture_);
    gl_->DeleteBuffers(1, &buffer_);
    gl_->ActiveTexture(GL_TEXTURE0);
  }

 private:
  const GlFunctions* gl_;
  GLuint buffer_ = 0;
  GLuint texture_ = 0;
};

}  // namespace

StripDecoder::StripDecoder(const GlFunctions& gl, Path path, ShaderProgram program)
    : gl_(&gl), path_(path), program_(std::move(program)) {
  if (path == Path::kCompute) {
    gl.GenBuffers(1, &counter_);
  } else {
    gl.GenVertexArrays(1, &no_attributes_);
  }
}

StripDecoder::StripDecoder(StripDecoder&& other) noexcept
    : gl_(other.gl_),
      path_(other.path_),
      program_(std::move(other.program_)),
      counter_(std::exchange(other.counter_, 0)),
      no_attributes_(std::exchange(other.no_attributes_, 0)) {}

StripDecoder::~StripDecoder() {
  if (counter_ != 0) gl_->DeleteBuffers(1, &counter_);
  if (no_attributes_ != 0) gl_->DeleteVertexArrays(1, &no_attributes_);
}

Expected<StripDecoder> StripDecoder::create(const GlFunctions& gl, std::optional<Path> path,
                                            std::int64_t buffer_bytes) {
  GLint most_bytes = 0;
  if (gl.DispatchCompute != nullptr) gl.GetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most_bytes);
  const bool can_compute = gl.DispatchCompute != nullptr && most_bytes >= buffer_bytes;
  const Path chosen = path.value_or(can_compute ? Path::kCompute : Path::kFeedback);
  if (chosen == Path::kCompute) {
    if (!can_compute) return fail(ErrorCode::kIo, "compute shaders need OpenGL 4.3, and this is " + gl.renderer);
    const std::array stages{
        ShaderStage{GL_COMPUTE_SHADER, "strip.comp.glsl", "strip_common.glsl", "#version 430 core\n"}};
    auto program = ShaderProgram::link(gl, stages);
    if (!program) return tl::unexpected(program.error());
    return StripDecoder(gl, chosen, std::move(*program));
  }
  const std::array stages{
      ShaderStage{GL_VERTEX_SHADER, "strip.vert.glsl"},
      ShaderStage{GL_GEOMETRY_SHADER, "strip.geom.glsl", "strip_common.glsl", "#version 330 core\n"}};
  auto program = ShaderProgram::link(gl, stages, "word");
  if (!program) return tl::unexpected(program.error());
  return StripDecoder(gl, chosen, std::move(*program));
}

Expected<void> StripDecoder::decode(const codec::StripPayload& payload, const codec::StripBorders& borders,
                                    const StripRange& out) const {
  if (!codec::unpacks_on_card(payload))
    return fail(ErrorCode::kBadData, "the tile's vertices do not fit into words of 32 bits");
  const GlFunctions& gl = *gl_;
  const TexelBuffer headers(gl, payload.headers, 0);
  const TexelBuffer entries(gl, payload.entries, 1);
  program_.use();
  gl.Uniform1i(program_.uniform("headers"), 0);
  gl.Uniform1i(program_.uniform("entries"), 1);
  gl.Uniform1ui(program_.uniform("triangles"), payload.triangles);
  gl.Uniform1i(program_.uniform("levels"), payload.levels);
  gl.Uniform1i(program_.uniform("height_bits"), payload.height_bits);
  gl.Uniform1ui(program_.uniform("missing"), payload.missing());
  gl.Uniform4i(program_.uniform("borders"), borders[0], borders[1], borders[2], borders[3]);
  if (path_ == Path::kCompute) {
    const std::uint32_t none = 0;
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, counter_);
    gl.BufferData(GL_SHADER_STORAGE_BUFFER, 4, &none, GL_DYNAMIC_COPY);
    gl.Uniform1ui(program_.uniform("first_word"), out.first_word);
    gl.Uniform1ui(program_.uniform("end_word"), out.first_word + out.triangle_words + out.skirt_words);
  }
  put_out(out, payload, false);
  if (out.skirt_words > 0) put_out(out, payload, true);
  if (path_ == Path::kCompute) gl.MemoryBarrier(GL_ALL_BARRIER_BITS);
  return {};
}

/// One pass over all sub-strips: the triangles, or the skirts behind them.
void StripDecoder::put_out(const StripRange& out, const codec::StripPayload& payload, bool skirts) const {
  const GlFunctions& gl = *gl_;
  gl.Uniform1i(program_.uniform("skirts"), skirts ? 1 : 0);
  if (path_ == Path::kCompute) {
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, out.buffer);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, counter_);
    gl.DispatchCompute((payload.sub_strips() + 63) / 64, 1, 1);
    return;
  }
  const GLintptr begin = GLintptr{4} * (out.first_word + (skirts ? out.triangle_words : 0));
  const GLsizeiptr size = GLsizeiptr{4} * (skirts ? out.skirt_words : out.triangle_words);
  gl.BindVertexArray(no_attributes_);
  gl.Enable(GL_RASTERIZER_DISCARD);
  gl.BindBufferRange(GL_TRANSFORM_FEEDBACK_BUFFER, 0, out.buffer, begin, size);
  gl.BeginTransformFeedback(GL_POINTS);
  gl.DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(payload.sub_strips()));
  gl.EndTransformFeedback();
  gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
  gl.Disable(GL_RASTERIZER_DISCARD);
  gl.BindVertexArray(0);
}

}  // namespace tintree::render
