#include "render/gpu_tile_pool.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace tintree::render {
namespace {

using cache::DrawVertex;
using cache::MorphVertex;
using cache::StripShape;

/// Ranges begin at multiples of a vertex, so that both vertices and indices (4 divides 12) lie where GL wants them.
constexpr std::size_t kUnit = sizeof(DrawVertex);
static_assert(kUnit == 3 * sizeof(std::uint32_t), "a unit has room for a strip's triangle");
constexpr std::size_t kPages = 8;  ///< Of a budget that is not large.

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

/// Locations as in shaders/terrain.vert.glsl.
void describe_vertex(const GlFunctions& gl) {
  constexpr GLsizei kStride = sizeof(DrawVertex);
  gl.VertexAttribIPointer(0, 4, GL_UNSIGNED_SHORT, kStride, offset(0));
  gl.VertexAttribPointer(1, 2, GL_SHORT, GL_TRUE, kStride, offset(offsetof(DrawVertex, normal_x)));
  for (GLuint location = 0; location < 2; ++location) gl.EnableVertexAttribArray(location);
}

/// The vertices between a tile's surface and its parent's.
void describe_morph_vertex(const GlFunctions& gl) {
  constexpr GLsizei kStride = sizeof(MorphVertex);
  gl.VertexAttribPointer(2, 4, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(MorphVertex, x)));
  gl.VertexAttribPointer(3, 4, GL_SHORT, GL_TRUE, kStride, offset(offsetof(MorphVertex, normal_x)));
  gl.VertexAttribIPointer(4, 1, GL_UNSIGNED_SHORT, kStride, offset(offsetof(MorphVertex, skirt)));
  for (GLuint location = 2; location < 5; ++location) gl.EnableVertexAttribArray(location);
}

/// A word of a strip is an index by itself.
void describe_nothing(const GlFunctions&) {}

}  // namespace

GpuTilePool::GpuTilePool(const GlFunctions& gl, const GpuBudgets& budgets, GpuMakers makers)
    : gl_(&gl),
      budgets_(budgets),
      textures_(gl),
      fine_textures_(gl, budgets.fine_texture_bytes, budgets.fine_texture_kinds),
      nested_(gl, budgets.nested_bytes),
      makers_(std::move(makers)) {}

GpuTilePool::~GpuTilePool() {
  for (const Entry& entry : entries_) destroy(*gl_, entry.tile.relief);
  for (const Page& page : pages_) free_page(page);
}

bool GpuTilePool::contains(const cache::TileRef& tile) const {
  const auto at = tiles_.find(tile);
  return at != tiles_.end() && !is_hollow(at->second->tile);
}

bool GpuTilePool::upload(const cache::TileRef& ref, const cache::DrawableTile& tile) {
  if (use(ref) != nullptr) return true;
  const GLuint parent = tile.relief ? parent_heights(*tile.relief, ref.tree) : 0;
  const bool relief = makers_.reliefs && tile.relief && (parent != 0 || !tile.relief->parent);
  const StripShape* strip = tile.native.strip.get();
  const bool lit_strip = strip != nullptr && tile.pictures.directions.size == 0;
  const std::size_t relief_bytes = relief      ? PatchReconstructor::bytes(*tile.relief)
                                   : lit_strip ? StripNormals::bytes(strip->strip())
                                               : 0;
  if (!make_room_for_pictures(tile.pictures.bytes() + relief_bytes)) return false;
  Entry out{ref, {}, {}, frame_, 0};
  const bool placed = tile.native.nested ? place_nested(tile, out)
                      : strip != nullptr ? place_strip(tile, out)
                                         : place_mesh(tile, out);
  if (!placed) return false;
  out.tile.frame = tile.frame;
  out.tile.pictures = textures_.upload(tile.pictures);
  if (relief) out.tile.relief = makers_.reliefs->make(*tile.relief, parent);
  if (lit_strip) {
    out.tile.relief.normals = makers_.strips->normals->make(strip->strip(), tile.frame, out.tile.strip.vertex_array,
                                                            out.tile.strip.first_word);
    out.tile.relief.bytes = relief_bytes;
  }
  const std::size_t picture_bytes = out.tile.pictures.bytes + out.tile.relief.bytes;
  picture_bytes_ += picture_bytes;
  out.tile.bytes += picture_bytes;
  bytes_ += out.tile.bytes;
  entries_.push_front(std::move(out));
  tiles_[ref] = entries_.begin();
  if (entries_.front().tile.chunk) owners_[entries_.front().owner] = entries_.begin();
  return true;
}

bool GpuTilePool::place_nested(const cache::DrawableTile& tile, Entry& out) {
  std::vector<std::uint64_t> put_out;
  out.owner = ++next_owner_;
  out.tile.chunk = nested_.take(out.owner, *tile.native.nested, frame_, put_out);
  for (const std::uint64_t owner : put_out) {
    const auto entry = owners_.at(owner);
    entry->tile.chunk.reset();
    evict(entry);
  }
  if (!out.tile.chunk) return false;
  out.tile.nested = tile.native.nested;
  out.tile.occluder = tile.occluder;
  out.tile.bytes = nested_.chunk_bytes(*out.tile.chunk);
  return true;
}

bool GpuTilePool::place_strip(const cache::DrawableTile& tile, Entry& out) {
  const StripShape& shape = *tile.native.strip;
  const std::uint32_t words = shape.triangle_words() + shape.skirt_words();
  if (!place(words / 3, out.place)) return false;
  const Page& page = pages_[out.place.page];
  const auto first_word = static_cast<std::uint32_t>(3 * out.place.begin);
  out.tile.strip = {page.strip_vertex_array, first_word,
                    shape.triangle_words(),  shape.skirt_words(),
                    tile.surface_triangles,  shape.strip().levels + 1,
                    shape.strip().z_shift,   shape.borders()};
  const auto decoded = makers_.strips->decoder.decode(
      shape.strip(), shape.borders(), {page.buffer, first_word, shape.triangle_words(), shape.skirt_words()});
  assert(decoded);
  static_cast<void>(decoded);
  out.tile.occluder = tile.occluder;
  out.tile.bytes = out.place.length * kUnit;
  return true;
}

bool GpuTilePool::place_mesh(const cache::DrawableTile& tile, Entry& out) {
  const std::size_t bytes = tile.vertex_bytes() + tile.index_bytes();
  // Vertices begin at multiples of their size, counted from the buffer's begin; where the range begins is not known
  // yet.
  const std::size_t morph_bytes = tile.morph ? tile.morph->bytes() + sizeof(MorphVertex) : 0;
  if (!place((bytes + morph_bytes + kUnit - 1) / kUnit, out.place)) return false;
  const Page& page = pages_[out.place.page];
  const std::size_t begin = out.place.begin * kUnit;
  gl_->BindBuffer(GL_ARRAY_BUFFER, page.buffer);
  const std::span<const DrawVertex> vertices(tile.vertices);
  out.tile.mesh = tile.indices.empty()
                      ? copy(page.vertex_array, begin, vertices, std::span<const std::uint32_t>(tile.wide_indices))
                      : copy(page.vertex_array, begin, vertices, std::span<const std::uint16_t>(tile.indices));
  out.tile.mesh.surface_triangles = tile.surface_triangles;
  if (tile.morph) {
    const std::size_t morph_begin =
        (begin + bytes + sizeof(MorphVertex) - 1) / sizeof(MorphVertex) * sizeof(MorphVertex);
    out.tile.morph = copy(page.morph_vertex_array, morph_begin, std::span<const MorphVertex>(tile.morph->vertices),
                          std::span<const std::uint32_t>(tile.morph->indices));
    out.tile.morph.surface_triangles = tile.morph->surface_triangles;
  }
  out.tile.occluder = tile.occluder;
  out.tile.bytes = out.place.length * kUnit;
  return true;
}

template <typename Vertex, typename Index>
GpuMesh GpuTilePool::copy(GLuint vertex_array, std::size_t at, std::span<const Vertex> vertices,
                          std::span<const Index> indices) {
  GpuMesh out;
  out.vertex_array = vertex_array;
  out.base_vertex = static_cast<GLint>(at / sizeof(Vertex));
  out.index_offset = at + vertices.size_bytes();
  out.index_type = sizeof(Index) == 2 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT;
  out.index_count = static_cast<GLsizei>(indices.size());
  gl_->BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(at), static_cast<GLsizeiptr>(vertices.size_bytes()),
                     vertices.data());
  gl_->BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(out.index_offset),
                     static_cast<GLsizeiptr>(indices.size_bytes()), indices.data());
  return out;
}

const GpuTile* GpuTilePool::use(const cache::TileRef& tile) {
  const auto at = tiles_.find(tile);
  if (at == tiles_.end()) return nullptr;
  if (is_hollow(at->second->tile)) {
    evict(at->second);
    return nullptr;
  }
  at->second->frame = frame_;
  if (at->second->tile.chunk) nested_.use(*at->second->tile.chunk, frame_);
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
  const std::size_t taken = std::min(reserved_bytes_ + aside_bytes_, budgets_.mesh_bytes);
  const std::size_t left = budgets_.mesh_bytes - taken;
  const std::size_t usual = std::clamp(budgets_.mesh_bytes / kPages, std::size_t{1} << 20, kLargestPage) / kUnit;
  const std::size_t units = std::min(std::max(usual, length), left / kUnit);
  if (units < length) return false;
  Page page{0, 0, 0, 0, RangeAllocator(units), units * kUnit};
  while (gl_->GetError() != GL_NO_ERROR) {
  }
  gl_->GenBuffers(1, &page.buffer);
  gl_->BindBuffer(GL_ARRAY_BUFFER, page.buffer);
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(units * kUnit), nullptr, GL_STATIC_DRAW);
  page.vertex_array = make_vertex_array(page.buffer, describe_vertex);
  page.morph_vertex_array = make_vertex_array(page.buffer, describe_morph_vertex);
  page.strip_vertex_array = make_vertex_array(page.buffer, describe_nothing);
  if (gl_->GetError() != GL_NO_ERROR) {
    // The card has less than the budget: what there is has to do.
    free_page(page);
    budgets_.mesh_bytes = taken;
    return false;
  }
  reserved_bytes_ += page.bytes;
  const auto given_back = std::ranges::find(pages_, GLuint{0}, &Page::buffer);
  if (given_back != pages_.end()) {
    *given_back = std::move(page);
  } else {
    pages_.push_back(std::move(page));
  }
  return true;
}

bool GpuTilePool::set_aside(std::size_t bytes) {
  aside_bytes_ = 0;
  if (bytes > budgets_.mesh_bytes) return false;
  while (reserved_bytes_ + bytes > budgets_.mesh_bytes) {
    if (!drop_page()) return false;
  }
  aside_bytes_ = bytes;
  return true;
}

bool GpuTilePool::drop_page() {
  std::vector<bool> kept(pages_.size());
  for (std::size_t i = 0; i < pages_.size(); ++i) kept[i] = pages_[i].buffer == 0;
  for (const Entry& e : entries_) {
    if (e.place.length > 0 && e.frame == frame_) kept[e.place.page] = true;
  }
  const auto at = std::ranges::find(kept, false);
  if (at == kept.end()) return false;
  const auto dropped = static_cast<std::size_t>(at - kept.begin());
  for (auto e = entries_.begin(); e != entries_.end();) {
    const auto entry = e++;
    if (entry->place.length > 0 && entry->place.page == dropped) evict(entry);
  }
  const Page& page = pages_[dropped];
  free_page(page);
  reserved_bytes_ -= page.bytes;
  pages_[dropped] = {0, 0, 0, 0, RangeAllocator(0), 0};
  return true;
}

void GpuTilePool::free_page(const Page& page) {
  for (const GLuint array : {page.vertex_array, page.morph_vertex_array, page.strip_vertex_array})
    gl_->DeleteVertexArrays(1, &array);
  gl_->DeleteBuffers(1, &page.buffer);
}

GLuint GpuTilePool::make_vertex_array(GLuint buffer, void (*describe)(const GlFunctions&)) {
  GLuint out = 0;
  gl_->GenVertexArrays(1, &out);
  gl_->BindVertexArray(out);
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer);
  describe(*gl_);
  gl_->BindVertexArray(0);
  return out;
}

bool GpuTilePool::make_room_for_pictures(std::size_t bytes) {
  while (bytes > 0 && picture_bytes_ + bytes > budgets_.picture_bytes) {
    if (entries_.empty() || entries_.back().frame == frame_) return false;
    evict_oldest();
  }
  return true;
}

GLuint GpuTilePool::parent_heights(const cache::TileRelief& relief, std::uint32_t tree) {
  if (!relief.parent) return 0;
  const GpuTile* parent = use({*relief.parent, tree});
  return parent == nullptr ? 0 : parent->relief.heights;
}

void GpuTilePool::evict(Entries::iterator entry) {
  if (entry->place.length > 0) pages_[entry->place.page].free.give(entry->place.begin, entry->place.length);
  if (entry->tile.chunk) nested_.give_back(*entry->tile.chunk);
  owners_.erase(entry->owner);
  bytes_ -= entry->tile.bytes;
  picture_bytes_ -= entry->tile.pictures.bytes + entry->tile.relief.bytes;
  textures_.give_back(entry->tile.pictures);
  destroy(*gl_, entry->tile.relief);
  tiles_.erase(entry->ref);
  entries_.erase(entry);
}

}  // namespace tintree::render
