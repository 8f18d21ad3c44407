#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include <glm/vec3.hpp>

#include "codec/error.h"
#include "codec/grid_frame.h"
#include "codec/nested_tile.h"
#include "render/camera.h"
#include "render/chunk_pool.h"
#include "render/gl_functions.h"
#include "render/nested_lod.h"
#include "render/nested_stitch.h"
#include "render/offscreen_target.h"
#include "render/shader_program.h"

namespace tintree::render {

/// A vertex as the graphics card gets it: 16 bytes.
struct NestedVertex {
  std::uint32_t xy = 0;    ///< Lower 16 bits of x and of y.
  std::uint32_t rest = 0;  ///< 22 bits of z, then the upper 3 bits of x and of y.
  std::array<std::int8_t, codec::NestedTile::kMostLevels - 1> rises{};
};
static_assert(sizeof(NestedVertex) == 16);

/// A tile to draw. What it points to must last as long as the tile is drawn.
struct NestedView {
  codec::TileId id;
  const codec::NestedTile* tile = nullptr;
};

struct NestedStyle {
  double pixel_error = 1;
  bool morph = false;  ///< Vertices flow between levels; else a tile is all of one level.
  bool stitch = true;  ///< Off only to see the gaps.
  glm::vec3 background{0};
};

struct NestedStats {
  std::uint64_t triangles = 0;
  std::uint64_t stitches = 0;      ///< Triangles between tiles.
  std::size_t vertex_bytes = 0;    ///< Sent to the card in this frame,
  std::size_t index_bytes = 0;     ///< likewise.
  std::uint32_t without_room = 0;  ///< Tiles that did not fit into the card's memory.
};

/// Draws tiles of method `nested` (Schneider and Westermann 2006, sections 5 and 6): each at the nested level that its
/// box's corners want, its vertices morphed by the vertex shader. Graphics memory comes in chunks of a ChunkPool; into
/// a tile's chunk go only the vertices that it has not had yet, and one level's indices. Neighbours are stitched along
/// their sides by triangles of no area whose vertices are copies that the same shader places. Lives and dies while its
/// context is current; not thread-safe.
class NestedDrawer {
 public:
  /// `gl` and the layout must outlive it. `largest_bytes`: chunk_bytes() of the largest tile.
  static Expected<NestedDrawer> create(const GlFunctions& gl, const codec::TreeLayout& layout, std::size_t gpu_bytes,
                                       std::size_t largest_bytes);
  NestedDrawer(NestedDrawer&& other) noexcept;
  NestedDrawer& operator=(NestedDrawer&&) = delete;
  ~NestedDrawer();

  /// Graphics memory that a tile takes with all its levels.
  static std::size_t chunk_bytes(const codec::NestedTile& tile);

  /// Fills `target`, whose size is the camera's, with these tiles; no two overlap.
  NestedStats draw(const OffscreenTarget& target, const Camera& camera, std::span<const NestedView> tiles,
                   const NestedStyle& style);

 private:
  struct Placed {
    const NestedView* view = nullptr;
    codec::GridFrame frame;
    std::array<std::int32_t, 2> z{};  // least and greatest, height steps
    CornerLevels corners{};
    int level = 0;
    std::size_t chunk = 0;
    bool resident = false;
  };
  struct Resident {
    std::size_t chunk = 0;
    int levels_sent = 0;  // vertices of so many levels are there
    int indices_of = -1;  // level
  };

  NestedDrawer(const GlFunctions& gl, const codec::TreeLayout& layout, ShaderProgram program, ChunkPool pool);
  Placed place(const Camera& camera, const NestedView& view, const NestedStyle& style) const;
  bool send(Placed& tile, NestedStats& stats);
  void set_tile(const Camera& camera, const Placed& tile, int which) const;
  void draw_tile(const Placed& tile) const;
  void stitch_sides(const Camera& camera, std::span<const Placed> tiles, NestedStats& stats);
  void stitch_pair(const Camera& camera, const Placed& one, const Placed& other, int side, NestedStats& stats);
  std::vector<BorderVertex> border(const Placed& tile, int side) const;

  const GlFunctions* gl_;
  const codec::TreeLayout* layout_;
  ShaderProgram program_;
  ChunkPool pool_;
  std::unordered_map<std::uint64_t, Resident> residents_;  // by TileId::key()
  std::uint64_t frame_ = 0;
  GLuint buffer_ = 0;
  GLuint array_ = 0;
  GLuint stitch_buffer_ = 0;
  GLuint stitch_array_ = 0;
};

}  // namespace tintree::render
