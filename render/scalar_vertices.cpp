#include "render/scalar_vertices.h"

#include <algorithm>
#include <utility>

namespace tintree::render {
namespace {

/// Behind those of pictures (render/fine_textures.cpp).
constexpr int kTableUnit = 5;

ShaderStage stage(std::string_view name) { return {GL_VERTEX_SHADER, name, "scalar_word.glsl", "#version 330 core\n"}; }

}  // namespace

GpuQuantizer make_quantizer(const GlFunctions& gl, const cache::QuantizedShape& shape) {
  GpuQuantizer out{shape.format, 0, 0, table_bytes(shape)};
  if (shape.table.empty()) return out;
  gl.GenBuffers(1, &out.table_buffer);
  gl.BindBuffer(GL_TEXTURE_BUFFER, out.table_buffer);
  gl.BufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(out.bytes), shape.table.data(), GL_STATIC_DRAW);
  gl.GenTextures(1, &out.table);
  gl.ActiveTexture(GL_TEXTURE0 + kTableUnit);
  gl.BindTexture(GL_TEXTURE_BUFFER, out.table);
  gl.TexBuffer(GL_TEXTURE_BUFFER, GL_R32UI, out.table_buffer);
  gl.ActiveTexture(GL_TEXTURE0);
  return out;
}

void destroy(const GlFunctions& gl, const GpuQuantizer& quantizer) {
  if (quantizer.table == 0) return;
  gl.DeleteTextures(1, &quantizer.table);
  gl.DeleteBuffers(1, &quantizer.table_buffer);
}

void set_quantizer(const GlFunctions& gl, const ShaderProgram& program, const GpuQuantizer& quantizer) {
  const cache::QuantizedFormat& f = quantizer.format;
  gl.Uniform4i(program.uniform("bits_and_ends"), f.x_bits, f.y_bits, f.width, f.height);
  gl.Uniform4i(program.uniform("quantizer"), f.side_low, f.low, f.step, quantizer.table != 0 ? 1 : 0);
  gl.Uniform1i(program.uniform("level_table"), kTableUnit);
  if (quantizer.table == 0) return;
  gl.ActiveTexture(GL_TEXTURE0 + kTableUnit);
  gl.BindTexture(GL_TEXTURE_BUFFER, quantizer.table);
  gl.ActiveTexture(GL_TEXTURE0);
}

Expected<std::unique_ptr<ScalarVertices>> ScalarVertices::create(const GlFunctions& gl) {
  auto sums = NormalSums::create(gl, stage("scalar_sums.vert.glsl"));
  if (!sums) return tl::unexpected(sums.error());
  auto lit = ShaderProgram::link(gl, std::array{stage("scalar_lit.vert.glsl")}, "lit");
  if (!lit) return tl::unexpected(lit.error());
  return std::unique_ptr<ScalarVertices>(new ScalarVertices(gl, std::move(*sums), std::move(*lit)));
}

ScalarVertices::ScalarVertices(const GlFunctions& gl, NormalSums sums, ShaderProgram lit)
    : gl_(&gl), sums_(std::move(sums)), lit_(std::move(lit)) {
  gl.GenBuffers(1, &words_);
  gl.GenVertexArrays(1, &vertex_array_);
  gl.BindVertexArray(vertex_array_);
  gl.BindBuffer(GL_ARRAY_BUFFER, words_);
  gl.VertexAttribIPointer(0, 1, GL_UNSIGNED_INT, 4, nullptr);
  gl.EnableVertexAttribArray(0);
  gl.BindVertexArray(0);
}

ScalarVertices::~ScalarVertices() {
  gl_->DeleteVertexArrays(1, &vertex_array_);
  gl_->DeleteBuffers(1, &words_);
}

void ScalarVertices::make(const cache::QuantizedShape& shape, const GpuQuantizer& quantizer,
                          const codec::GridFrame& frame, const Triangles& triangles, GLuint out_buffer,
                          std::size_t out_offset) const {
  const GlFunctions& gl = *gl_;
  const std::size_t count = shape.words.size();
  gl.BindBuffer(GL_ARRAY_BUFFER, words_);
  gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(4 * count), shape.words.data(), GL_STREAM_DRAW);
  gl.BindVertexArray(vertex_array_);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles.buffer);
  sums_.program().use();
  set_quantizer(gl, sums_.program(), quantizer);
  const int places = std::max(shape.format.width, shape.format.height) + 1;
  const GLuint sums = [&] {
    // Feedback too wants a whole framebuffer: that of before.
    const TargetGuard guard(gl);
    return sums_.make(frame, 0, places, [&] {
      gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * triangles.count), triangles.index_type,
                      reinterpret_cast<const void*>(triangles.offset));
    });
  }();

  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);  // What feedback writes to must not be read from.
  gl.BindTexture(GL_TEXTURE_2D, sums);
  lit_.use();
  set_quantizer(gl, lit_, quantizer);
  gl.Uniform1i(lit_.uniform("sums"), 0);
  gl.Enable(GL_RASTERIZER_DISCARD);
  gl.BindBufferRange(GL_TRANSFORM_FEEDBACK_BUFFER, 0, out_buffer, static_cast<GLintptr>(out_offset),
                     static_cast<GLsizeiptr>(sizeof(LitWord) * count));
  gl.BeginTransformFeedback(GL_POINTS);
  gl.DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(count));
  gl.EndTransformFeedback();
  gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
  gl.Disable(GL_RASTERIZER_DISCARD);
  gl.BindVertexArray(0);
  gl.DeleteTextures(1, &sums);
}

}  // namespace tintree::render
