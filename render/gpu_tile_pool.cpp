#include "render/gpu_tile_pool.h"

#include <algorithm>
#include <vector>

namespace tintree::render {
namespace {

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

/// Locations as in shaders/terrain.vert.glsl.
void describe_vertex(const GlFunctions& gl) {
  using cache::DrawVertex;
  constexpr GLsizei kStride = sizeof(DrawVertex);
  gl.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(DrawVertex, x)));
  gl.VertexAttribPointer(1, 1, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(DrawVertex, z)));
  gl.VertexAttribIPointer(2, 1, GL_UNSIGNED_SHORT, kStride, offset(offsetof(DrawVertex, skirt)));
  gl.VertexAttribPointer(3, 2, GL_SHORT, GL_TRUE, kStride, offset(offsetof(DrawVertex, normal_x)));
  for (GLuint location = 0; location < 4; ++location) gl.EnableVertexAttribArray(location);
}

void describe_morph_vertex(const GlFunctions& gl) {
  using cache::MorphVertex;
  constexpr GLsizei kStride = sizeof(MorphVertex);
  gl.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(MorphVertex, x)));
  gl.VertexAttribPointer(1, 1, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(MorphVertex, z)));
  gl.VertexAttribIPointer(2, 1, GL_UNSIGNED_SHORT, kStride, offset(offsetof(MorphVertex, skirt)));
  gl.VertexAttribPointer(3, 2, GL_SHORT, GL_TRUE, kStride, offset(offsetof(MorphVertex, normal_x)));
  gl.VertexAttribPointer(4, 1, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(MorphVertex, goal_z)));
  gl.VertexAttribPointer(5, 2, GL_SHORT, GL_TRUE, kStride, offset(offsetof(MorphVertex, goal_normal_x)));
  for (GLuint location = 0; location < 6; ++location) gl.EnableVertexAttribArray(location);
}

}  // namespace

GpuTilePool::~GpuTilePool() {
  for (const auto& [key, entry] : tiles_) free(entry.tile);
}

void GpuTilePool::upload(const cache::DrawableTile& tile) {
  if (contains(tile.id)) return;
  GpuTile out;
  const std::size_t vertex_bytes = tile.vertices.size() * sizeof(cache::DrawVertex);
  const std::size_t index_bytes = tile.indices.size() * sizeof(std::uint32_t);
  gl_->GenVertexArrays(1, &out.vertex_array);
  gl_->BindVertexArray(out.vertex_array);
  gl_->GenBuffers(1, &out.vertices);
  gl_->BindBuffer(GL_ARRAY_BUFFER, out.vertices);
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertex_bytes), tile.vertices.data(), GL_STATIC_DRAW);
  gl_->GenBuffers(1, &out.indices);
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, out.indices);
  gl_->BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(index_bytes), tile.indices.data(), GL_STATIC_DRAW);
  describe_vertex(*gl_);
  if (tile.morph) upload_morph(*tile.morph, out);
  gl_->BindVertexArray(0);
  out.index_count = static_cast<GLsizei>(tile.indices.size());
  out.surface_triangles = tile.surface_triangles;
  out.frame = tile.frame;
  out.occluder = tile.occluder;
  out.bytes = vertex_bytes + index_bytes + (tile.morph ? tile.morph->bytes() : 0);
  bytes_ += out.bytes;
  tiles_[tile.id.key()] = {out, frame_};
}

void GpuTilePool::upload_morph(const cache::MorphMesh& mesh, GpuTile& out) {
  const auto bytes = [](const auto& list) { return static_cast<GLsizeiptr>(list.size() * sizeof list[0]); };
  gl_->GenVertexArrays(1, &out.morph.vertex_array);
  gl_->BindVertexArray(out.morph.vertex_array);
  gl_->GenBuffers(1, &out.morph.vertices);
  gl_->BindBuffer(GL_ARRAY_BUFFER, out.morph.vertices);
  gl_->BufferData(GL_ARRAY_BUFFER, bytes(mesh.vertices), mesh.vertices.data(), GL_STATIC_DRAW);
  gl_->GenBuffers(1, &out.morph.indices);
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, out.morph.indices);
  gl_->BufferData(GL_ELEMENT_ARRAY_BUFFER, bytes(mesh.indices), mesh.indices.data(), GL_STATIC_DRAW);
  describe_morph_vertex(*gl_);
  out.morph.index_count = static_cast<GLsizei>(mesh.indices.size());
  out.morph.surface_triangles = mesh.surface_triangles;
}

const GpuTile* GpuTilePool::use(const codec::TileId& id) {
  const auto at = tiles_.find(id.key());
  if (at == tiles_.end()) return nullptr;
  at->second.frame = frame_;
  return &at->second.tile;
}

void GpuTilePool::end_frame() {
  if (bytes_ > budget_bytes_) {
    std::vector<std::pair<std::uint64_t, std::int64_t>> unused;
    for (const auto& [key, entry] : tiles_) {
      if (entry.frame < frame_) unused.emplace_back(entry.frame, key);
    }
    std::ranges::sort(unused);
    for (const auto& [frame, key] : unused) {
      if (bytes_ <= budget_bytes_) break;
      const auto at = tiles_.find(key);
      bytes_ -= at->second.tile.bytes;
      free(at->second.tile);
      tiles_.erase(at);
    }
  }
  ++frame_;
}

void GpuTilePool::free(const GpuTile& tile) {
  gl_->DeleteVertexArrays(1, &tile.vertex_array);
  gl_->DeleteBuffers(1, &tile.vertices);
  gl_->DeleteBuffers(1, &tile.indices);
  if (tile.morph.vertex_array == 0) return;
  gl_->DeleteVertexArrays(1, &tile.morph.vertex_array);
  gl_->DeleteBuffers(1, &tile.morph.vertices);
  gl_->DeleteBuffers(1, &tile.morph.indices);
}

}  // namespace tintree::render
