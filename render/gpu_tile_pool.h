#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>

#include "cache/drawable_tile.h"
#include "codec/grid_frame.h"
#include "render/gl_functions.h"

namespace tintree::render {

/// The overlay of a tile with its parent in the graphics card's memory.
struct GpuMorph {
  GLuint vertex_array = 0;  ///< 0 for none.
  GLuint vertices = 0;
  GLuint indices = 0;
  GLsizei index_count = 0;
  std::uint32_t surface_triangles = 0;
};

/// A tile in the graphics card's memory.
struct GpuTile {
  GLuint vertex_array = 0;
  GLuint vertices = 0;
  GLuint indices = 0;
  GLsizei index_count = 0;  ///< Surface and skirt.
  std::uint32_t surface_triangles = 0;
  GpuMorph morph;
  codec::GridFrame frame;
  std::shared_ptr<const cache::Occluder> occluder;
  std::size_t bytes = 0;
};

/// The tiles uploaded so far, least recently used first to go. Lives and dies while its context is current;
/// not thread-safe.
class GpuTilePool {
 public:
  /// `budget_bytes`: graphics memory for tiles; a frame that draws more keeps what it draws.
  GpuTilePool(const GlFunctions& gl, std::size_t budget_bytes) : gl_(&gl), budget_bytes_(budget_bytes) {}
  ~GpuTilePool();
  GpuTilePool(const GpuTilePool&) = delete;
  GpuTilePool& operator=(const GpuTilePool&) = delete;

  bool contains(const codec::TileId& id) const { return tiles_.contains(id.key()); }
  void upload(const cache::DrawableTile& tile);
  /// The tile, marked as used in this frame, or null.
  const GpuTile* use(const codec::TileId& id);
  /// Ends a frame: frees what was not used in it, the longest unused first, while over the budget.
  void end_frame();

  std::size_t bytes() const { return bytes_; }
  std::size_t tiles() const { return tiles_.size(); }

 private:
  struct Entry {
    GpuTile tile;
    std::uint64_t frame = 0;  ///< That used it last.
  };

  void upload_morph(const cache::MorphMesh& mesh, GpuTile& out);
  void free(const GpuTile& tile);

  const GlFunctions* gl_;
  std::size_t budget_bytes_;
  std::size_t bytes_ = 0;
  std::uint64_t frame_ = 0;
  std::unordered_map<std::int64_t, Entry> tiles_;
};

}  // namespace tintree::render
