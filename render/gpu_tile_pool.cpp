#include "render/gpu_tile_pool.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace tintree::render {
namespace {

using cache::DrawVertex;
using cache::MorphVertex;
using cache::QuantizedShape;
using cache::StripShape;

}  // namespace

GpuTilePool::GpuTilePool(const GlFunctions& gl, const GpuBudgets& budgets, GpuMakers makers)
    : gl_(&gl),
      most_picture_bytes_(budgets.picture_bytes),
      pages_(gl, budgets.mesh_bytes),
      textures_(gl),
      fine_textures_(gl, budgets.fine_texture_bytes, budgets.fine_texture_kinds),
      nested_(gl, budgets.nested_bytes),
      makers_(std::move(makers)) {}

GpuTilePool::~GpuTilePool() {
  for (const Entry& entry : entries_) {
    destroy(*gl_, entry.tile.relief);
    if (entry.tile.quantizer) destroy(*gl_, *entry.tile.quantizer);
  }
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
  const QuantizedShape* quantized = tile.native.scalar.get();
  const std::size_t levels_bytes = quantized != nullptr ? table_bytes(*quantized) : 0;
  if (!make_room_for_pictures(tile.pictures.bytes() + relief_bytes + levels_bytes)) return false;
  Entry out{ref, {}, {}, frame_, 0};
  const bool placed = tile.native.nested     ? place_nested(tile, out)
                      : strip != nullptr     ? place_strip(tile, out)
                      : quantized != nullptr ? place_quantized(tile, out)
                                             : place_mesh(tile, out);
  if (!placed) return false;
  out.tile.frame = tile.native.nested ? tile.native.nested->frame : tile.frame;
  out.tile.pictures = textures_.upload(tile.pictures);
  if (relief) out.tile.relief = makers_.reliefs->make(*tile.relief, parent);
  if (lit_strip) {
    out.tile.relief.normals = makers_.strips->normals->make(strip->strip(), tile.frame, out.tile.strip.vertex_array,
                                                            out.tile.strip.first_word);
    out.tile.relief.bytes = relief_bytes;
  }
  picture_bytes_ += picture_bytes(out.tile);
  out.tile.bytes += picture_bytes(out.tile);
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
  const GpuPage& page = pages_.page(out.place);
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
  out.tile.bytes = out.place.bytes();
  return true;
}

bool GpuTilePool::place_quantized(const cache::DrawableTile& tile, Entry& out) {
  const QuantizedShape& shape = *tile.native.scalar;
  // Vertices begin at multiples of their size, counted from the buffer's begin.
  const std::size_t bytes = (shape.words.size() + 1) * sizeof(LitWord) + tile.index_bytes();
  if (!place((bytes + GpuPages::kUnit - 1) / GpuPages::kUnit, out.place)) return false;
  const GpuPage& page = pages_.page(out.place);
  const std::size_t begin =
      (out.place.begin * GpuPages::kUnit + sizeof(LitWord) - 1) / sizeof(LitWord) * sizeof(LitWord);
  const std::size_t indices = begin + shape.words.size() * sizeof(LitWord);
  gl_->BindBuffer(GL_ARRAY_BUFFER, page.buffer);
  const std::span<const LitWord> none;
  GpuMesh& mesh = out.tile.quantized;
  mesh = tile.indices.empty()
             ? copy(page.lit_vertex_array, indices, none, std::span<const std::uint32_t>(tile.wide_indices))
             : copy(page.lit_vertex_array, indices, none, std::span<const std::uint16_t>(tile.indices));
  mesh.base_vertex = static_cast<GLint>(begin / sizeof(LitWord));
  mesh.surface_triangles = tile.surface_triangles;
  out.tile.quantizer = make_quantizer(*gl_, shape);
  makers_.scalars->make(shape, *out.tile.quantizer, tile.frame,
                        {page.buffer, mesh.index_offset, mesh.index_type, mesh.surface_triangles}, page.buffer, begin);
  out.tile.occluder = tile.occluder;
  out.tile.bytes = out.place.bytes();
  return true;
}

bool GpuTilePool::place_mesh(const cache::DrawableTile& tile, Entry& out) {
  const std::size_t bytes = tile.vertex_bytes() + tile.index_bytes();
  // Vertices begin at multiples of their size, counted from the buffer's begin; where the range begins is not known
  // yet.
  const std::size_t morph_bytes = tile.morph ? tile.morph->bytes() + sizeof(MorphVertex) : 0;
  if (!place((bytes + morph_bytes + GpuPages::kUnit - 1) / GpuPages::kUnit, out.place)) return false;
  const GpuPage& page = pages_.page(out.place);
  const std::size_t begin = out.place.begin * GpuPages::kUnit;
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
  out.tile.bytes = out.place.bytes();
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

bool GpuTilePool::place(std::size_t length, PageRange& out) {
  while (true) {
    if (const auto range = pages_.take(length)) {
      out = *range;
      return true;
    }
    if (entries_.empty() || entries_.back().frame == frame_) return false;
    evict_oldest();
  }
}

bool GpuTilePool::set_aside(std::size_t bytes) {
  while (!pages_.set_aside(bytes)) {
    if (bytes > pages_.budget_bytes() || !drop_page()) return false;
  }
  return true;
}

bool GpuTilePool::drop_page() {
  std::vector<bool> kept(pages_.count());
  for (const Entry& e : entries_) {
    if (e.place.length > 0 && e.frame == frame_) kept[e.place.page] = true;
  }
  const auto page = pages_.find_page(kept);
  if (!page) return false;
  for (auto e = entries_.begin(); e != entries_.end();) {
    const auto entry = e++;
    if (entry->place.length > 0 && entry->place.page == *page) evict(entry);
  }
  pages_.drop(*page);
  return true;
}

bool GpuTilePool::make_room_for_pictures(std::size_t bytes) {
  while (bytes > 0 && picture_bytes_ + bytes > most_picture_bytes_) {
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
  if (entry->place.length > 0) pages_.give_back(entry->place);
  if (entry->tile.chunk) nested_.give_back(*entry->tile.chunk);
  owners_.erase(entry->owner);
  bytes_ -= entry->tile.bytes;
  picture_bytes_ -= picture_bytes(entry->tile);
  textures_.give_back(entry->tile.pictures);
  destroy(*gl_, entry->tile.relief);
  if (entry->tile.quantizer) destroy(*gl_, *entry->tile.quantizer);
  tiles_.erase(entry->ref);
  entries_.erase(entry);
}

}  // namespace tintree::render
