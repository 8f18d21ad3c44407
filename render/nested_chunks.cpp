#include "render/nested_chunks.h"

#include <algorithm>
#include <span>
#include <utility>

namespace tintree::render {
namespace {

using cache::NestedShape;
using cache::NestedVertex;

constexpr std::size_t kSmallestChunk = std::size_t{32} << 10;
constexpr std::size_t kVertexBytes = sizeof(NestedVertex);
constexpr std::size_t kIndexBytes = sizeof(std::uint32_t);

std::size_t vertex_room(const NestedShape& shape) { return shape.vertices.size() * kVertexBytes; }

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

}  // namespace

/// Locations as in shaders/nested.vert.glsl.
void describe_nested_vertex(const GlFunctions& gl, GLsizei stride) {
  gl.VertexAttribIPointer(0, 2, GL_UNSIGNED_INT, stride, offset(offsetof(NestedVertex, xy)));
  gl.VertexAttribPointer(1, 4, GL_BYTE, GL_FALSE, stride, offset(offsetof(NestedVertex, rises)));
  gl.VertexAttribPointer(2, 4, GL_BYTE, GL_FALSE, stride, offset(offsetof(NestedVertex, rises) + 4));
  gl.VertexAttribPointer(3, 2, GL_SHORT, GL_TRUE, stride, offset(offsetof(NestedVertex, normal)));
  gl.VertexAttribPointer(4, 4, GL_BYTE, GL_TRUE, stride, offset(offsetof(NestedVertex, coarse_normals)));
  for (GLuint location = 0; location < 5; ++location) gl.EnableVertexAttribArray(location);
}

NestedChunks::NestedChunks(const GlFunctions& gl, std::size_t budget_bytes)
    : gl_(&gl), pool_(budget_bytes, kSmallestChunk) {}

NestedChunks::~NestedChunks() {
  for (Memory& m : memory_) free(m);
}

std::size_t NestedChunks::bytes_for(const NestedShape& shape) {
  std::size_t most = 0;
  for (const auto& fans : shape.fans.fans) most = std::max(most, fans.size());
  return vertex_room(shape) + most * kIndexBytes;
}

void NestedChunks::free(Memory& memory) {
  if (memory.array != 0) gl_->DeleteVertexArrays(1, &memory.array);
  if (memory.buffer != 0) gl_->DeleteBuffers(1, &memory.buffer);
  memory = {};
}

bool NestedChunks::allocate(std::size_t size, Memory& out) {
  while (gl_->GetError() != GL_NO_ERROR) {
  }
  gl_->GenVertexArrays(1, &out.array);
  gl_->BindVertexArray(out.array);
  gl_->GenBuffers(1, &out.buffer);
  gl_->BindBuffer(GL_ARRAY_BUFFER, out.buffer);
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, out.buffer);
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(size), nullptr, GL_DYNAMIC_DRAW);
  describe_nested_vertex(*gl_, kVertexBytes);
  gl_->BindVertexArray(0);
  out.size = size;
  return gl_->GetError() == GL_NO_ERROR;
}

std::optional<std::size_t> NestedChunks::take(std::uint64_t owner, const NestedShape& shape, std::uint64_t frame,
                                              std::vector<std::uint64_t>& put_out) {
  const auto chunk = pool_.take(owner, bytes_for(shape), frame, put_out);
  const std::vector<ChunkPool::Chunk>& chunks = pool_.chunks();
  memory_.resize(chunks.size());
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    if (memory_[i].size != chunks[i].size) free(memory_[i]);
  }
  if (!chunk) return chunk;
  Memory& memory = memory_[*chunk];
  memory.levels_sent = 0;
  memory.indices_of = -1;
  if (memory.size > 0 || allocate(chunks[*chunk].size, memory)) return chunk;
  // The card has less than the budget.
  free(memory);
  pool_.give_back(*chunk);
  return std::nullopt;
}

std::size_t NestedChunks::send(std::size_t chunk, const NestedShape& shape, int level) {
  Memory& memory = memory_[chunk];
  std::size_t sent = 0;
  const auto copy = [&](std::size_t at, auto values) {
    gl_->BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(at), static_cast<GLsizeiptr>(values.size_bytes()),
                       values.data());
    sent += values.size_bytes();
  };
  gl_->BindBuffer(GL_ARRAY_BUFFER, memory.buffer);
  if (memory.levels_sent <= level) {
    const std::size_t first = memory.levels_sent == 0 ? 0 : shape.level_vertices(memory.levels_sent - 1);
    const std::span<const NestedVertex> all(shape.vertices);
    copy(first * kVertexBytes, all.subspan(first, shape.level_vertices(level) - first));
    memory.levels_sent = level + 1;
  }
  if (std::exchange(memory.indices_of, level) != level)
    copy(vertex_room(shape), std::span<const std::uint32_t>(shape.level_fans(level)));
  return sent;
}

void NestedChunks::draw(std::size_t chunk, const NestedShape& shape) const {
  const Memory& memory = memory_[chunk];
  gl_->BindVertexArray(memory.array);
  gl_->DrawElements(GL_TRIANGLE_FAN, static_cast<GLsizei>(shape.level_fans(memory.indices_of).size()), GL_UNSIGNED_INT,
                    offset(vertex_room(shape)));
}

}  // namespace tintree::render
