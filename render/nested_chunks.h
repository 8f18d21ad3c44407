#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cache/nested_shape.h"
#include "render/chunk_pool.h"
#include "render/gl_functions.h"

namespace tintree::render {

/// Nested tiles on the graphics card, each in a chunk of a ChunkPool with room for all of its levels. Into it go only
/// the vertices that it has not had yet, and one level's indices. Lives and dies while its context is current; not
/// thread-safe.
class NestedChunks {
 public:
  NestedChunks(const GlFunctions& gl, std::size_t budget_bytes);
  ~NestedChunks();
  NestedChunks(const NestedChunks&) = delete;
  NestedChunks& operator=(const NestedChunks&) = delete;

  /// Graphics memory that a tile takes with all its levels.
  static std::size_t bytes_for(const cache::NestedShape& shape);

  /// As ChunkPool::take().
  std::optional<std::size_t> take(std::uint64_t owner, const cache::NestedShape& shape, std::uint64_t frame,
                                  std::vector<std::uint64_t>& put_out);
  void use(std::size_t chunk, std::uint64_t frame) { pool_.use(chunk, frame); }
  void give_back(std::size_t chunk) { pool_.give_back(chunk); }
  std::size_t chunk_bytes(std::size_t chunk) const { return pool_.chunks()[chunk].size; }
  std::size_t reserved_bytes() const { return pool_.bytes(); }

  /// Sends what the chunk lacks of a level of its tile. Returns the bytes sent.
  std::size_t send(std::size_t chunk, const cache::NestedShape& shape, int level);
  /// Draws the level that was sent last.
  void draw(std::size_t chunk, const cache::NestedShape& shape) const;

 private:
  struct Memory {
    std::size_t size = 0;
    GLuint buffer = 0;
    GLuint array = 0;
    int levels_sent = 0;  // vertices of so many levels are there
    int indices_of = -1;  // level
  };
  void free(Memory& memory);
  bool allocate(std::size_t size, Memory& out);

  const GlFunctions* gl_;
  ChunkPool pool_;
  std::vector<Memory> memory_;  // of the pool's chunks
};

/// Describes NestedVertex at the begin of vertices of `stride` bytes in the bound buffer to the bound vertex array.
void describe_nested_vertex(const GlFunctions& gl, GLsizei stride);

}  // namespace tintree::render
