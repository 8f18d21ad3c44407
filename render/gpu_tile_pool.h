#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "cache/drawable_tile.h"
#include "cache/tile_ref.h"
#include "codec/grid_frame.h"
#include "render/fine_textures.h"
#include "render/gl_functions.h"
#include "render/gpu_pages.h"
#include "render/nested_chunks.h"
#include "render/patch_reconstructor.h"
#include "render/picture_textures.h"
#include "render/scalar_vertices.h"
#include "render/strip_unpacker.h"

namespace tintree::render {

/// A mesh in a range of one of the pool's buffers.
struct GpuMesh {
  GLuint vertex_array = 0;  ///< Of the whole buffer, shared with other tiles; 0 for no mesh.
  GLint base_vertex = 0;
  std::size_t index_offset = 0;         ///< Bytes into the buffer.
  GLenum index_type = GL_UNSIGNED_INT;  ///< Or GL_UNSIGNED_SHORT.
  GLsizei index_count = 0;              ///< Surface and skirt.
  std::uint32_t surface_triangles = 0;
};

/// A strip's words (codec/strip_list.h) in a range of one of the pool's buffers.
struct GpuStrip {
  GLuint vertex_array = 0;  ///< Without attributes; the whole buffer's words are its indices. 0 for no strip.
  std::uint32_t first_word = 0;
  std::uint32_t triangle_words = 0;
  std::uint32_t skirt_words = 0;
  std::uint32_t surface_triangles = 0;  ///< Without those of holes, which have words.
  int xy_bits = 0;
  int z_shift = 0;
  codec::StripBorders borders{};
};

/// A tile in the graphics card's memory: a mesh, or what its cache::NativeGround takes there.
struct GpuTile {
  GpuMesh mesh;
  GpuMesh morph;  ///< The overlay with its parent.
  GpuStrip strip;
  GpuMesh quantized;  ///< Of LitWord, read by
  std::optional<GpuQuantizer> quantizer;
  codec::GridFrame frame;  ///< Of what is drawn: a nested shape has its own.
  std::shared_ptr<const cache::Occluder> occluder;
  GpuPictures pictures;
  GpuRelief relief;  ///< Of a strip, the normals of its vertices.
  std::size_t bytes = 0;
  /// Of a tile that is drawn by its nested levels. The shape is the cache's: without it, the tile is not there.
  std::optional<std::size_t> chunk;
  std::weak_ptr<const cache::NestedShape> nested;

  bool is_mesh() const { return mesh.vertex_array != 0; }
};

/// Graphics memory for tiles, by what it holds; never exceeded.
struct GpuBudgets {
  std::size_t mesh_bytes = 0;     ///< Strips' words too, and what is set aside.
  std::size_t picture_bytes = 0;  ///< Reliefs and tables of heights too.
  std::size_t nested_bytes = 0;
  std::size_t fine_texture_bytes = 0;  ///< For textures on squares in leaves,
  std::size_t fine_texture_kinds = 0;  ///< of so many kinds.
};

/// Makes on the card what is not sent there; null for what no tree needs.
struct GpuMakers {
  std::unique_ptr<PatchReconstructor> reliefs;  ///< Without it, reliefs are left out.
  std::unique_ptr<StripUnpacker> strips;        ///< Without it no tile may be a strip,
  std::unique_ptr<ScalarVertices> scalars;      ///< and without this none may be quantised.
};

/// The tiles uploaded so far, overlays too, in ranges of a few large buffers: a new tile takes the place of the least
/// recently used, and once the budget has been filled nothing more is allocated. Lives and dies while its context is
/// current; not thread-safe.
class GpuTilePool {
 public:
  GpuTilePool(const GlFunctions& gl, const GpuBudgets& budgets, GpuMakers makers = {});
  ~GpuTilePool();
  GpuTilePool(const GpuTilePool&) = delete;
  GpuTilePool& operator=(const GpuTilePool&) = delete;

  bool contains(const cache::TileRef& tile) const;
  /// Copies the tile to the card and marks it as used in this frame. False when it does not fit beside what this frame
  /// has used so far.
  /// The tile's relief is made where its parent's is here; else the tile is lit by its mesh. A strip that has no normal
  /// map is lit by one that is made here.
  bool upload(const cache::TileRef& ref, const cache::DrawableTile& tile);
  /// The tile, marked as used in this frame, or null.
  const GpuTile* use(const cache::TileRef& tile);
  /// Keeps that much of the memory for meshes free for something else, instead of what it kept before; buffers that are
  /// too many then are given back with their tiles. False, and nothing is set aside any more, when it cannot because of
  /// what this frame has used so far.
  bool set_aside(std::size_t bytes);
  /// From here on what has been used before may make room.
  void end_frame() {
    ++frame_;
    fine_textures_.end_frame();
  }

  const PictureTextures& textures() const { return textures_; }
  NestedChunks& nested() { return nested_; }
  FineTextures& fine_textures() { return fine_textures_; }
  const FineTextures& fine_textures() const { return fine_textures_; }
  std::size_t bytes() const { return bytes_ + fine_textures_.bytes(); }
  std::size_t tiles() const { return tiles_.size(); }
  /// Of the buffers, tiles or not.
  std::size_t reserved_bytes() const {
    return pages_.reserved_bytes() + nested_.reserved_bytes() + fine_textures_.reserved_bytes();
  }
  bool makes_reliefs() const { return makers_.reliefs != nullptr; }
  bool has_strips() const { return makers_.strips != nullptr; }
  bool has_scalars() const { return makers_.scalars != nullptr; }

 private:
  struct Entry {
    cache::TileRef ref;
    GpuTile tile;
    PageRange place;
    std::uint64_t frame = 0;  ///< That used it last.
    std::uint64_t owner = 0;  ///< Of its chunk.
  };
  using Entries = std::list<Entry>;

  /// What a tile takes of GpuBudgets::picture_bytes.
  static std::size_t picture_bytes(const GpuTile& tile) {
    return tile.pictures.bytes + tile.relief.bytes + (tile.quantizer ? tile.quantizer->bytes : 0);
  }
  /// Whether the tile's nested levels have left the cache.
  static bool is_hollow(const GpuTile& tile) { return tile.chunk && tile.nested.expired(); }
  bool place_mesh(const cache::DrawableTile& tile, Entry& out);
  bool place_nested(const cache::DrawableTile& tile, Entry& out);
  bool place_strip(const cache::DrawableTile& tile, Entry& out);
  bool place_quantized(const cache::DrawableTile& tile, Entry& out);
  /// Copies arrays into a page's buffer, the vertices to `at` bytes into it and the indices behind them.
  template <typename Vertex, typename Index>
  GpuMesh copy(GLuint vertex_array, std::size_t at, std::span<const Vertex> vertices, std::span<const Index> indices);
  /// Finds room, evicting what this frame does not use.
  bool place(std::size_t length, PageRange& out);
  /// Gives back a buffer that this frame does not use; false when there is none.
  bool drop_page();
  void evict_oldest() { evict(std::prev(entries_.end())); }
  void evict(Entries::iterator entry);
  /// The same for a tile's pictures.
  bool make_room_for_pictures(std::size_t bytes);
  /// The heights that a tile's relief is made of, kept while it is; 0 where there are none.
  GLuint parent_heights(const cache::TileRelief& relief, std::uint32_t tree);

  const GlFunctions* gl_;
  std::size_t most_picture_bytes_;  ///< Reliefs too.
  GpuPages pages_;
  PictureTextures textures_;
  FineTextures fine_textures_;
  NestedChunks nested_;
  GpuMakers makers_;
  std::size_t bytes_ = 0;
  std::size_t picture_bytes_ = 0;  ///< Of these, reliefs and tables too.
  std::uint64_t frame_ = 0;
  std::uint64_t next_owner_ = 0;
  std::unordered_map<std::uint64_t, Entries::iterator> owners_;  ///< Of chunks.
  Entries entries_;                                              ///< The most recently used first.
  std::unordered_map<cache::TileRef, Entries::iterator, cache::TileRefHash> tiles_;
};

}  // namespace tintree::render
