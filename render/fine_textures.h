#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "cache/tile_ref.h"
#include "codec/texture_codec.h"
#include "render/gl_functions.h"
#include "render/lod_cut.h"
#include "render/shader_program.h"

namespace tintree::render {

/// The textures of squares in leaves (LodCut::parts) on the card. A leaf is drawn at once, whatever lies on it: the
/// textures of a kind are layers of one array, made when the first comes, and a table has a row for every leaf with
/// such textures, and in it a number for each of the smallest squares in the leaf, which says the layer and how large
/// its square is. The least recently used layer makes room. Lives and dies while its context is current; not
/// thread-safe.
class FineTextures {
 public:
  /// `bytes`: of graphics memory, never exceeded, in equal shares for each of `kinds` pairs of format and size.
  FineTextures(const GlFunctions& gl, std::size_t bytes, std::size_t kinds);
  ~FineTextures();
  FineTextures(const FineTextures&) = delete;
  FineTextures& operator=(const FineTextures&) = delete;

  /// Whether the square has a texture; nothing while that is not known here.
  std::optional<bool> find(const cache::TileRef& square) const;
  /// The same, marked as used in this frame.
  std::optional<bool> use(const cache::TileRef& square);
  /// Copies a square's texture to the card, or keeps in mind that it has none (size 0), and marks it as used in this
  /// frame. False when it does not fit beside what this frame has used so far.
  bool upload(const cache::TileRef& square, const codec::PixelArray& pixels);
  /// From here on what has been used before may make room.
  void end_frame() { ++frame_; }

  /// Fills the table before a cut's tiles are drawn. What has left the card since is stood in for by coarser ones.
  void prepare(Trees trees, const LodCut& cut);
  /// Whether the cut has any.
  bool in_use() const { return rows_ > 0; }
  /// Tells the program in use, of the ground's, what lies on a tile; to be called for every tile where in_use().
  void set_look(const ShaderProgram& program, const DrawTile& drawn) const;
  /// Tells it that nothing does, and where to look.
  static void begin(const GlFunctions& gl, const ShaderProgram& program);

  std::size_t bytes() const { return bytes_; }
  std::size_t reserved_bytes() const { return reserved_bytes_; }
  std::size_t textures() const { return textures_; }

 private:
  using Kind = std::pair<codec::PixelFormat, int>;  ///< Format and size.
  struct Array {
    GLuint texture = 0;
    std::size_t layer_bytes = 0;
    std::vector<int> free;  ///< Layers.
  };
  struct Entry {
    cache::TileRef square;
    Array* array = nullptr;  ///< Null for a square without a texture.
    int layer = 0;
    std::uint64_t frame = 0;  ///< That used it last.
  };
  using Entries = std::list<Entry>;

  Array& array_of(const codec::PixelArray& pixels);
  void allocate(const codec::PixelArray& pixels, Array& out);
  /// Finds a free layer, evicting what this frame does not use.
  bool find_layer(Array& array);
  void evict(Entries::iterator entry);
  void copy(const codec::PixelArray& pixels, const Array& array, int layer) const;

  const GlFunctions* gl_;
  std::size_t share_bytes_;
  std::size_t bytes_ = 0;
  std::size_t reserved_bytes_ = 0;
  std::size_t textures_ = 0;
  std::uint64_t frame_ = 0;
  std::map<Kind, Array> arrays_;
  std::map<std::uint32_t, GLuint> array_of_tree_;
  Entries entries_;  ///< The most recently used first.
  std::unordered_map<cache::TileRef, Entries::iterator, cache::TileRefHash> by_square_;
  GLuint table_ = 0;
  int rows_ = 0;             ///< Of the table that the cut uses.
  std::vector<int> depths_;  ///< Of the cut's trees.
};

}  // namespace tintree::render
