#include "render/gpu_tile_pool.h"

#include <algorithm>

namespace tintree::render {
namespace {

using cache::DrawVertex;

/// Ranges begin at multiples of a vertex, so that both vertices and indices (4 divides 12) lie where GL wants them.
constexpr std::size_t kUnit = sizeof(DrawVertex);
constexpr std::size_t kLargestPage = std::size_t{64} << 20;
constexpr std::size_t kPages = 8;  ///< Of a budget that is not large.

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

/// Locations as in shaders/terrain.vert.glsl.
void describe_vertex(const GlFunctions& gl) {
  constexpr GLsizei kStride = sizeof(DrawVertex);
  gl.VertexAttribIPointer(0, 4, GL_UNSIGNED_SHORT, kStride, offset(0));
  gl.VertexAttribPointer(1, 2, GL_SHORT, GL_TRUE, kStride, offset(offsetof(DrawVertex, normal_x)));
  for (GLuint location = 0; location < 2; ++location) gl.EnableVertexAttribArray(location);
}

}  // namespace

GpuTilePool::GpuTilePool(const GlFunctions& gl, std::size_t budget_bytes) : gl_(&gl), budget_bytes_(budget_bytes) {}

GpuTilePool::~GpuTilePool() {
  for (const Page& page : pages_) {
    gl_->DeleteVertexArrays(1, &page.vertex_array);
    gl_->DeleteBuffers(1, &page.buffer);
  }
}

bool GpuTilePool::upload(const cache::TileRef& ref, const cache::DrawableTile& tile) {
  if (use(ref) != nullptr) return true;
  const std::size_t bytes = tile.vertex_bytes() + tile.index_bytes();
  Place at;
  if (!place((bytes + kUnit - 1) / kUnit, at)) return false;
  const Page& page = pages_[at.page];
  const bool wide = tile.indices.empty();
  const void* indices = wide ? static_cast<const void*>(tile.wide_indices.data()) : tile.indices.data();
  GpuTile out;
  out.vertex_array = page.vertex_array;
  out.base_vertex = static_cast<GLint>(at.begin);
  out.index_offset = at.begin * kUnit + tile.vertex_bytes();
  out.index_type = wide ? GL_UNSIGNED_INT : GL_UNSIGNED_SHORT;
  out.index_count = static_cast<GLsizei>(tile.index_count());
  out.surface_triangles = tile.surface_triangles;
  out.frame = tile.frame;
  out.bytes = at.length * kUnit;
  gl_->BindBuffer(GL_ARRAY_BUFFER, page.buffer);
  gl_->BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(at.begin * kUnit),
                     static_cast<GLsizeiptr>(tile.vertex_bytes()), tile.vertices.data());
  gl_->BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(out.index_offset),
                     static_cast<GLsizeiptr>(tile.index_bytes()), indices);
  bytes_ += out.bytes;
  entries_.push_front({ref, out, at, frame_});
  tiles_[ref] = entries_.begin();
  return true;
}

const GpuTile* GpuTilePool::use(const cache::TileRef& tile) {
  const auto at = tiles_.find(tile);
  if (at == tiles_.end()) return nullptr;
  at->second->frame = frame_;
  entries_.splice(entries_.begin(), entries_, at->second);
  return &at->second->tile;
}

bool GpuTilePool::place(std::size_t length, Place& out) {
  while (true) {
    if (find_gap(length, out)) return true;
    if (add_page(length)) continue;
    if (entries_.empty() || entries_.back().frame == frame_) return false;
    evict_oldest();
  }
}

bool GpuTilePool::find_gap(std::size_t length, Place& out) {
  for (std::size_t i = 0; i < pages_.size(); ++i) {
    if (const auto begin = pages_[i].free.take(length)) {
      out = {i, *begin, length};
      return true;
    }
  }
  return false;
}

bool GpuTilePool::add_page(std::size_t length) {
  const std::size_t left = budget_bytes_ - std::min(reserved_bytes_, budget_bytes_);
  const std::size_t usual = std::clamp(budget_bytes_ / kPages, std::size_t{1} << 20, kLargestPage) / kUnit;
  const std::size_t units = std::min(std::max(usual, length), left / kUnit);
  if (units < length) return false;
  Page page{0, 0, RangeAllocator(units)};
  while (gl_->GetError() != GL_NO_ERROR) {
  }
  gl_->GenVertexArrays(1, &page.vertex_array);
  gl_->BindVertexArray(page.vertex_array);
  gl_->GenBuffers(1, &page.buffer);
  gl_->BindBuffer(GL_ARRAY_BUFFER, page.buffer);
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, page.buffer);
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(units * kUnit), nullptr, GL_STATIC_DRAW);
  describe_vertex(*gl_);
  gl_->BindVertexArray(0);
  if (gl_->GetError() != GL_NO_ERROR) {
    // The card has less than the budget: what there is has to do.
    gl_->DeleteVertexArrays(1, &page.vertex_array);
    gl_->DeleteBuffers(1, &page.buffer);
    budget_bytes_ = reserved_bytes_;
    return false;
  }
  pages_.push_back(std::move(page));
  reserved_bytes_ += units * kUnit;
  return true;
}

void GpuTilePool::evict_oldest() {
  const Entry& oldest = entries_.back();
  pages_[oldest.place.page].free.give(oldest.place.begin, oldest.place.length);
  bytes_ -= oldest.tile.bytes;
  tiles_.erase(oldest.ref);
  entries_.pop_back();
}

}  // namespace tintree::render
