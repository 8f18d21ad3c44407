#include "render/strip_decoder.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <utility>

#include "codec/strip_list.h"

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

/// Room for the skirts: a border edge is at least a step long, and a triangle has at most one.
std::uint32_t most_skirt_words(const codec::StripPayload& p) {
  return 6 * std::min(p.triangles, std::uint32_t{4} << p.levels);
}

}  // namespace

StripWordBuffer::StripWordBuffer(const GlFunctions& gl, std::uint32_t capacity_words) : gl_(&gl) {
  gl.GenBuffers(1, &id_);
  gl.BindBuffer(GL_ARRAY_BUFFER, id_);
  gl.BufferData(GL_ARRAY_BUFFER, GLsizeiptr{4} * capacity_words, nullptr, GL_DYNAMIC_COPY);
}

StripWordBuffer::StripWordBuffer(StripWordBuffer&& other) noexcept
    : triangle_words(other.triangle_words),
      skirt_words(other.skirt_words),
      gl_(other.gl_),
      id_(std::exchange(other.id_, 0)) {}

StripWordBuffer::~StripWordBuffer() {
  if (id_ != 0) gl_->DeleteBuffers(1, &id_);
}

std::vector<std::uint32_t> StripWordBuffer::read(std::uint32_t first, std::uint32_t count) const {
  std::vector<std::uint32_t> out(count);
  gl_->BindBuffer(GL_ARRAY_BUFFER, id_);
  gl_->GetBufferSubData(GL_ARRAY_BUFFER, GLintptr{4} * first, GLsizeiptr{4} * count, out.data());
  return out;
}

StripDecoder::StripDecoder(const GlFunctions& gl, Path path, ShaderProgram program)
    : gl_(&gl), path_(path), program_(std::move(program)) {}

Expected<StripDecoder> StripDecoder::create(const GlFunctions& gl, std::optional<Path> path) {
  const bool can_compute = gl.DispatchCompute != nullptr;
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

Expected<StripWordBuffer> StripDecoder::decode(const codec::StripPayload& payload) const {
  if (payload.levels > codec::kShortLevels || !codec::StripWords(payload).fit())
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
  StripWordBuffer words(gl, 3 * payload.triangles + most_skirt_words(payload));
  words.triangle_words = 3 * payload.triangles;
  GLuint counter = 0;
  if (path_ == Path::kCompute) {
    const std::uint32_t none = 0;
    gl.GenBuffers(1, &counter);
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, counter);
    gl.BufferData(GL_SHADER_STORAGE_BUFFER, 4, &none, GL_DYNAMIC_COPY);
    put_out(words, payload, false, counter);
    put_out(words, payload, true, counter);
    gl.MemoryBarrier(GL_ALL_BARRIER_BITS);
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, counter);
    gl.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, 4, &words.skirt_words);
    gl.DeleteBuffers(1, &counter);
  } else {
    put_out(words, payload, false, 0);
    GLuint query = 0;
    gl.GenQueries(1, &query);
    gl.BeginQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, query);
    put_out(words, payload, true, 0);
    gl.EndQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
    gl.GetQueryObjectuiv(query, GL_QUERY_RESULT, &words.skirt_words);
    gl.DeleteQueries(1, &query);
  }
  words.skirt_words = std::min(words.skirt_words, most_skirt_words(payload));
  return words;
}

/// One pass over all sub-strips: the triangles, or the skirts behind them.
void StripDecoder::put_out(const StripWordBuffer& words, const codec::StripPayload& payload, bool skirts,
                           GLuint counter) const {
  const GlFunctions& gl = *gl_;
  gl.Uniform1i(program_.uniform("skirts"), skirts ? 1 : 0);
  if (path_ == Path::kCompute) {
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, words.id());
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, counter);
    gl.DispatchCompute((payload.sub_strips() + 63) / 64, 1, 1);
    return;
  }
  const GLintptr begin = skirts ? GLintptr{12} * payload.triangles : 0;
  const GLsizeiptr size = skirts ? GLsizeiptr{4} * most_skirt_words(payload) : GLsizeiptr{12} * payload.triangles;
  GLuint no_attributes = 0;
  gl.GenVertexArrays(1, &no_attributes);
  gl.BindVertexArray(no_attributes);
  gl.Enable(GL_RASTERIZER_DISCARD);
  gl.BindBufferRange(GL_TRANSFORM_FEEDBACK_BUFFER, 0, words.id(), begin, size);
  gl.BeginTransformFeedback(GL_POINTS);
  gl.DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(payload.sub_strips()));
  gl.EndTransformFeedback();
  gl.Disable(GL_RASTERIZER_DISCARD);
  gl.BindVertexArray(0);
  gl.DeleteVertexArrays(1, &no_attributes);
}

Expected<StripDrawer> StripDrawer::create(const GlFunctions& gl) {
  auto program = ShaderProgram::create(gl, "strip_draw.vert.glsl", "line.frag.glsl");
  if (!program) return tl::unexpected(program.error());
  return StripDrawer(gl, std::move(*program));
}

void StripDrawer::draw(const StripWordBuffer& words, const codec::StripHead& head, const std::array<float, 16>& matrix,
                       float foot_depth) const {
  const GlFunctions& gl = *gl_;
  program_.use();
  gl.UniformMatrix4fv(program_.uniform("matrix"), 1, GL_FALSE, matrix.data());
  gl.Uniform1i(program_.uniform("levels"), head.levels);
  gl.Uniform1f(program_.uniform("highest"), static_cast<float>(std::max(1U, (1U << head.height_bits) - 1)));
  gl.Uniform1f(program_.uniform("foot_depth"), foot_depth);
  GLuint no_attributes = 0;
  gl.GenVertexArrays(1, &no_attributes);
  gl.BindVertexArray(no_attributes);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, words.id());
  gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(words.triangle_words + words.skirt_words), GL_UNSIGNED_INT,
                  nullptr);
  gl.BindVertexArray(0);
  gl.DeleteVertexArrays(1, &no_attributes);
}

}  // namespace tintree::render
