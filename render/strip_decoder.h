#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "codec/error.h"
#include "codec/strip_payload.h"
#include "render/gl_functions.h"
#include "render/shader_program.h"

namespace tintree::render {

/// Words of a decoded tile (codec/strip_list.h) in a buffer of the context, its triangles first, then its skirts: an
/// index buffer whose indices are the vertices themselves (Dick et al. 2009, section 6). Lives and dies while its
/// context is current.
class StripWordBuffer {
 public:
  StripWordBuffer(const GlFunctions& gl, std::uint32_t capacity_words);
  StripWordBuffer(StripWordBuffer&& other) noexcept;
  StripWordBuffer& operator=(StripWordBuffer&&) = delete;
  ~StripWordBuffer();

  GLuint id() const { return id_; }
  std::vector<std::uint32_t> read(std::uint32_t first, std::uint32_t count) const;

  std::uint32_t triangle_words = 0;
  std::uint32_t skirt_words = 0;

 private:
  const GlFunctions* gl_;
  GLuint id_ = 0;
};

/// Decodes tiles of method `strip` on the graphics card: only the payload goes there. To be used on the context's
/// thread.
class StripDecoder {
 public:
  enum class Path {
    kCompute,   ///< OpenGL 4.3. Skirts come in any order.
    kFeedback,  ///< OpenGL 3.3: geometry shader and transform feedback; words in the order of codec::follow_strip().
  };

  /// The compute path where the context has it, unless told otherwise. `gl` must outlive it.
  static Expected<StripDecoder> create(const GlFunctions& gl, std::optional<Path> path = {});

  Path path() const { return path_; }

  /// Decodes a payload that StripMesh::decode() would accept, of a tile of at most 2^10 steps whose vertices fit into
  /// words (codec::StripWords). Fails with kBadData on others; a damaged payload gives a wrong list and no more.
  Expected<StripWordBuffer> decode(const codec::StripPayload& payload) const;

 private:
  StripDecoder(const GlFunctions& gl, Path path, ShaderProgram program);
  void put_out(const StripWordBuffer& words, const codec::StripPayload& payload, bool skirts, GLuint counter) const;

  const GlFunctions* gl_;
  Path path_;
  ShaderProgram program_;
};

/// Draws decoded tiles straight from their words: the index of a vertex is all that there is of it, and the card's
/// vertex cache sees that neighbours in the strip share two. Heights are shades of grey.
class StripDrawer {
 public:
  static Expected<StripDrawer> create(const GlFunctions& gl);

  /// `matrix` is column-major, from (x, y, height) in the payload's units to clip space; skirts reach `foot_depth`
  /// units of height down.
  void draw(const StripWordBuffer& words, const codec::StripHead& head, const std::array<float, 16>& matrix,
            float foot_depth) const;

 private:
  StripDrawer(const GlFunctions& gl, ShaderProgram program) : gl_(&gl), program_(std::move(program)) {}

  const GlFunctions* gl_;
  ShaderProgram program_;
};

}  // namespace tintree::render
