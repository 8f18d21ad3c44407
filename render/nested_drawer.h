#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "cache/nested_shape.h"
#include "codec/error.h"
#include "render/camera.h"
#include "render/gl_functions.h"
#include "render/gpu_tile_pool.h"
#include "render/ground_style.h"
#include "render/lod_cut.h"
#include "render/shader_program.h"

namespace tintree::render {

/// Draws tiles of method `nested` (Schneider and Westermann 2006, sections 5 and 6): each by the nested level that
/// DrawTile::nested_level says or, where the cut morphs, by surfaces between levels that the vertex shader makes.
/// Neighbours are stitched along their sides by triangles of no area whose vertices are copies that the same shader
/// places, so nothing is open between them; a skirt hangs where the neighbour is not drawn by nested levels. Lives and
/// dies while its context is current; not thread-safe.
class NestedDrawer {
 public:
  /// `gl` must outlive it. Fails with kIo when the driver refuses a shader.
  static Expected<NestedDrawer> create(const GlFunctions& gl);
  NestedDrawer(NestedDrawer&& other) noexcept;
  NestedDrawer& operator=(NestedDrawer&&) = delete;
  ~NestedDrawer();

  /// For what is the same for all tiles of a picture.
  const ShaderProgram& program() const { return program_; }

  /// Draws those tiles of a part of the cut that have nested levels, and what joins them to their neighbours in all of
  /// it, with what program() has been told.
  void draw(const Camera& camera, Trees trees, const LodCut& cut, std::span<const DrawTile> part, GpuTilePool& pool,
            const Style& style, DrawStats& stats) const;

 private:
  struct Placed {
    const DrawTile* draw = nullptr;
    codec::TileId id;
    const GpuTile* tile = nullptr;
    std::shared_ptr<const cache::NestedShape> shape;
  };
  using Neighbours = std::unordered_map<cache::TileRef, const Placed*, cache::TileRefHash>;
  /// Whose a vertex between tiles is, behind its NestedVertex.
  struct StitchVertex {
    cache::NestedVertex vertex;
    std::uint16_t second = 0;
    std::uint16_t skirt_sides = 0;
  };
  using Line = std::vector<cache::BorderVertex>;
  /// Of one of the two tiles that vertices may belong to.
  struct Places {
    GLint address_to_eye, coarse_units, fine_units, detail;
  };

  NestedDrawer(const GlFunctions& gl, ShaderProgram program);
  std::vector<Placed> place(Trees trees, const LodCut& cut, GpuTilePool& pool) const;
  void set_tile(const Camera& camera, Trees trees, const LodCut& cut, const Placed& tile, std::size_t which) const;
  void draw_sides(const Camera& camera, Trees trees, const LodCut& cut, const GpuTilePool& pool, const Style& style,
                  const Placed& tile, const Neighbours& drawn) const;
  /// What surface joins along a side.
  std::vector<Line> border(const Placed& tile, std::size_t side) const;
  std::vector<StitchVertex> stitches(const Placed& tile, const Placed& neighbour, std::size_t side) const;
  std::vector<StitchVertex> skirt(const Placed& tile, std::size_t side) const;
  void draw_side(const std::vector<StitchVertex>& vertices) const;

  const GlFunctions* gl_;
  ShaderProgram program_;
  std::array<Places, 2> at_{};
  GLuint stitch_buffer_ = 0;
  GLuint stitch_array_ = 0;
};

}  // namespace tintree::render
