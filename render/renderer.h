#pragma once

#include <span>

#include "cache/tile_bounds.h"
#include "codec/error.h"
#include "render/camera.h"
#include "render/gl_functions.h"
#include "render/gpu_tile_pool.h"
#include "render/ground_style.h"
#include "render/lod_cut.h"
#include "render/nested_drawer.h"
#include "render/offscreen_target.h"
#include "render/scalar_drawer.h"
#include "render/shader_program.h"
#include "render/strip_drawer.h"

namespace tintree::render {

/// Draws a cut: every tile through the matrix that takes its grid addresses to metres relative to the eye
/// (codec::GridFrame::matrix, made in double), lit by the sun, tinted by height, with reversed depth. What a tile is on
/// the card, a mesh, nested levels, a strip or a quantised grid, decides how it is drawn; all are lit by one fragment
/// shader. Lives and dies while its context is current; not thread-safe.
class Renderer {
 public:
  /// `gl` must outlive it. Fails with kIo when the driver refuses a shader.
  static Expected<Renderer> create(const GlFunctions& gl);

  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) = delete;
  ~Renderer();

  /// Fills `target`, whose size is the camera's: draw_background(), then draw_ground().
  DrawStats draw(const OffscreenTarget& target, const Camera& camera, Trees trees, const LodCut& cut, GpuTilePool& pool,
                 const Style& style) const;
  void draw_background(const OffscreenTarget& target, const Camera& camera, const Style& style) const;
  /// Draws into what is bound. Tiles of the cut that the pool lacks are left out.
  DrawStats draw_ground(const Camera& camera, Trees trees, const LodCut& cut, GpuTilePool& pool,
                        const Style& style) const;
  /// The same of a part of the cut, a piece of its `draws`. All parts, one after the other, make the same picture.
  DrawStats draw_ground(const Camera& camera, Trees trees, const LodCut& cut, std::span<const DrawTile> part,
                        GpuTilePool& pool, const Style& style) const;

  /// The depth that draw() gives the nearest plane, metres: depth = near_m / OffscreenTarget::read_depth().
  double near_m(const LodCut& cut) const;

  /// What gaps between tiles measure at most, as metres across the view a metre of depth: the larger of one pixel and
  /// the largest error drawn (at most 16 pixels, while finer tiles are on their way).
  static double gap_slope(const Camera& camera, const LodCut& cut);

 private:
  Renderer(const GlFunctions& gl, ShaderProgram terrain, NestedDrawer nested, StripDrawer strips, ScalarDrawer scalars,
           ShaderProgram sky);
  /// Uses a program of the ground and tells it what is the same for all tiles.
  void begin(const ShaderProgram& program, const Camera& camera, Trees trees, const LodCut& cut,
             const Style& style) const;
  void draw_meshes(const Camera& camera, Trees trees, std::span<const DrawTile> draws, GpuTilePool& pool,
                   const Style& style, DrawStats& stats) const;

  const GlFunctions* gl_;
  ShaderProgram terrain_;
  NestedDrawer nested_;
  StripDrawer strips_;
  ScalarDrawer scalars_;
  ShaderProgram sky_;
  GLuint no_vertices_ = 0;  ///< The core profile demands a vertex array even where there is no vertex.
};

}  // namespace tintree::render
