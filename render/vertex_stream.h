#pragma once

#include <cstddef>
#include <span>

#include "render/gl_functions.h"

namespace tintree::render {

/// Vertices of floats that are sent anew for every draw. Lives and dies while its context is current; not thread-safe.
class VertexStream {
 public:
  /// A vertex is made of attributes of so many floats each, in the order of the shader's locations. `gl` must outlive
  /// it.
  VertexStream(const GlFunctions& gl, std::span<const GLint> attributes);
  VertexStream(VertexStream&& other) noexcept;
  VertexStream& operator=(VertexStream&&) = delete;
  ~VertexStream();

  /// Sends the vertices and draws them as `primitives` by the program in use. A Vertex has no padding.
  template <typename Vertex>
  void draw(GLenum primitives, std::span<const Vertex> vertices) const {
    draw(primitives, std::as_bytes(vertices), vertices.size());
  }

 private:
  void draw(GLenum primitives, std::span<const std::byte> bytes, std::size_t vertices) const;

  const GlFunctions* gl_;
  GLuint array_ = 0;
  GLuint buffer_ = 0;
};

}  // namespace tintree::render
