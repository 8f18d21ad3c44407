#pragma once

#include <cstddef>
#include <memory>

#include "cache/quantized_shape.h"
#include "codec/error.h"
#include "codec/grid_frame.h"
#include "render/gl_functions.h"
#include "render/normal_sums.h"
#include "render/shader_program.h"

namespace tintree::render {

/// How the vertices of a tile of method `scalar` are read on the card.
struct GpuQuantizer {
  cache::QuantizedFormat format;
  GLuint table = 0;  ///< Heights of indices, a buffer texture of R32UI; 0 for a uniform quantiser.
  GLuint table_buffer = 0;
  std::size_t bytes = 0;  ///< Of the table.
};
inline std::size_t table_bytes(const cache::QuantizedShape& shape) { return 4 * shape.table.size(); }
GpuQuantizer make_quantizer(const GlFunctions& gl, const cache::QuantizedShape& shape);
void destroy(const GlFunctions& gl, const GpuQuantizer& quantizer);
/// Tells the program in use what scalar_word.glsl needs.
void set_quantizer(const GlFunctions& gl, const ShaderProgram& program, const GpuQuantizer& quantizer);

/// One of a tile's vertices as ScalarVertices makes them.
struct LitWord {
  std::uint32_t word = 0;     ///< cache::QuantizedFormat.
  std::int16_t normal_x = 0;  ///< As cache::DrawVertex.
  std::int16_t normal_y = 0;
};
static_assert(sizeof(LitWord) == 8);

/// Makes vertices with normals of words, on the card: the normals are those that cache::make_drawable() makes, but for
/// rounding, and need not be sent. Lives and dies while its context is current; not thread-safe.
class ScalarVertices {
 public:
  /// `gl` must outlive it. Fails with kIo when the driver refuses a shader.
  static Expected<std::unique_ptr<ScalarVertices>> create(const GlFunctions& gl);
  ~ScalarVertices();
  ScalarVertices(const ScalarVertices&) = delete;
  ScalarVertices& operator=(const ScalarVertices&) = delete;

  /// Triangles in a buffer, three indices each.
  struct Triangles {
    GLuint buffer = 0;
    std::size_t offset = 0;  ///< Bytes.
    GLenum index_type = GL_UNSIGNED_INT;
    std::uint32_t count = 0;
  };
  /// Puts a LitWord for each of the shape's words into `out_buffer` from `out_offset` (bytes, a multiple of 4) on.
  /// `frame`: of the tile. The framebuffer that is bound and the viewport stay as they are. It takes 16 bytes of the
  /// card's memory for each of the tile's places while it works.
  void make(const cache::QuantizedShape& shape, const GpuQuantizer& quantizer, const codec::GridFrame& frame,
            const Triangles& triangles, GLuint out_buffer, std::size_t out_offset) const;

 private:
  ScalarVertices(const GlFunctions& gl, NormalSums sums, ShaderProgram lit);

  const GlFunctions* gl_;
  NormalSums sums_;
  ShaderProgram lit_;
  GLuint words_ = 0;
  GLuint vertex_array_ = 0;
};

}  // namespace tintree::render
