#pragma once

#include <cstdint>
#include <optional>

#include "codec/error.h"
#include "codec/strip_list.h"
#include "codec/strip_payload.h"
#include "render/gl_functions.h"
#include "render/shader_program.h"

namespace tintree::render {

/// Where in a buffer a tile's words go (codec/strip_list.h), its triangles first, then its skirts: a piece of an index
/// buffer whose indices are the vertices themselves (Dick et al. 2009, section 6).
struct StripRange {
  GLuint buffer = 0;
  std::uint32_t first_word = 0;
  std::uint32_t triangle_words = 0;
  std::uint32_t skirt_words = 0;  ///< As many as the tile's skirts have: nothing has to be asked of the card.
};

/// Decodes tiles of method `strip` on the graphics card: only the payload goes there. To be used on the context's
/// thread.
class StripDecoder {
 public:
  enum class Path {
    kCompute,   ///< OpenGL 4.3. Skirts come in any order.
    kFeedback,  ///< OpenGL 3.3: geometry shader and transform feedback; words in the order of codec::follow_strip().
  };

  /// The compute path where the context has it for buffers of `buffer_bytes`, unless told otherwise. `gl` must outlive
  /// it.
  static Expected<StripDecoder> create(const GlFunctions& gl, std::optional<Path> path = {},
                                       std::int64_t buffer_bytes = 0);
  StripDecoder(StripDecoder&& other) noexcept;
  StripDecoder& operator=(StripDecoder&&) = delete;
  ~StripDecoder();

  Path path() const { return path_; }

  /// Decodes a payload that StripMesh::decode() would accept, of a tile of at most 2^10 steps whose vertices fit into
  /// words (codec::StripWords). Fails with kBadData on others; a damaged payload gives a wrong list and touches nothing
  /// else.
  Expected<void> decode(const codec::StripPayload& payload, const codec::StripBorders& borders,
                        const StripRange& out) const;

 private:
  StripDecoder(const GlFunctions& gl, Path path, ShaderProgram program);
  void put_out(const StripRange& out, const codec::StripPayload& payload, bool skirts) const;

  const GlFunctions* gl_;
  Path path_;
  ShaderProgram program_;
  GLuint counter_ = 0;        ///< Of skirt words; the compute path's.
  GLuint no_attributes_ = 0;  ///< The feedback path's vertex array.
};

}  // namespace tintree::render
