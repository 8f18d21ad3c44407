#include "render/vertex_stream.h"

#include <numeric>
#include <utility>

namespace tintree::render {

VertexStream::VertexStream(const GlFunctions& gl, std::span<const GLint> attributes) : gl_(&gl) {
  gl.GenVertexArrays(1, &array_);
  gl.BindVertexArray(array_);
  gl.GenBuffers(1, &buffer_);
  gl.BindBuffer(GL_ARRAY_BUFFER, buffer_);
  const auto vertex_bytes =
      static_cast<GLsizei>(sizeof(GLfloat)) * std::accumulate(attributes.begin(), attributes.end(), 0);
  std::size_t offset = 0;
  for (GLuint location = 0; const GLint floats : attributes) {
    gl.VertexAttribPointer(location, floats, GL_FLOAT, GL_FALSE, vertex_bytes, reinterpret_cast<void*>(offset));
    gl.EnableVertexAttribArray(location++);
    offset += sizeof(GLfloat) * static_cast<std::size_t>(floats);
  }
  gl.BindVertexArray(0);
}

VertexStream::VertexStream(VertexStream&& other) noexcept
    : gl_(other.gl_), array_(std::exchange(other.array_, 0)), buffer_(std::exchange(other.buffer_, 0)) {}

VertexStream::~VertexStream() {
  if (array_ == 0) return;
  gl_->DeleteVertexArrays(1, &array_);
  gl_->DeleteBuffers(1, &buffer_);
}

void VertexStream::draw(GLenum primitives, std::span<const std::byte> bytes, std::size_t vertices) const {
  gl_->BindVertexArray(array_);
  gl_->BindBuffer(GL_ARRAY_BUFFER, buffer_);
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes.size()), bytes.data(), GL_STREAM_DRAW);
  gl_->DrawArrays(primitives, 0, static_cast<GLsizei>(vertices));
  gl_->BindVertexArray(0);
}

}  // namespace tintree::render
