#pragma once

#include <cstdint>
#include <optional>

#include <glm/vec3.hpp>

#include "cache/tile_bounds.h"
#include "codec/error.h"
#include "render/camera.h"
#include "render/gl_functions.h"
#include "render/gpu_tile_pool.h"
#include "render/lod_cut.h"
#include "render/offscreen_target.h"
#include "render/shader_program.h"
#include "render/tile_tint.h"

namespace tintree::render {

/// How the ground looks.
struct Style {
  double sun_azimuth_rad = 5.4977871437821382;    ///< Where the sun stands, clockwise from north: north-west.
  double sun_elevation_rad = 0.5934119456780721;  ///< Above the horizon: 34 degrees.
  /// One sRGB colour (0 to 1) behind the ground, without haze before it; without it, a sky.
  std::optional<glm::vec3> background;
  Tint tint = Tint::kHeight;
  double allowed_px = 1;  ///< What Tint::kError measures errors by.
  /// Metres from the eye at which fog takes 95 hundredths of the ground's light; 0: the air of a clear day, by the
  /// scene's size.
  double fog_m = 0;
  bool wireframe = false;
  bool skirts = true;  ///< Off only to see the gaps that they fill.
};

/// What a frame drew.
struct DrawStats {
  std::uint32_t tiles = 0;
  std::uint32_t draw_calls = 0;
  std::uint64_t triangles = 0;  ///< Of surfaces; skirts are not counted.
  /// Tiles that an impostor stood in for, and triangles drawn into a new one.
  std::uint32_t impostor_tiles = 0;
  std::uint64_t impostor_triangles = 0;
};

/// Draws a cut: every tile through the matrix that takes its grid addresses to metres relative to the eye
/// (codec::GridFrame::matrix, made in double), lit by the sun, tinted by height, with reversed depth.
/// Lives and dies while its context is current; not thread-safe.
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

  /// The depth that draw() gives the nearest plane, metres: depth = near_m / OffscreenTarget::read_depth().
  double near_m(const LodCut& cut) const;

  /// What gaps between tiles measure at most, as metres across the view a metre of depth: the larger of one pixel and
  /// the largest error drawn (at most 16 pixels, while finer tiles are on their way).
  static double gap_slope(const Camera& camera, const LodCut& cut);

 private:
  Renderer(const GlFunctions& gl, ShaderProgram terrain, ShaderProgram sky);
  void set_terrain_uniforms(const Camera& camera, Trees trees, const LodCut& cut, const Style& style) const;

  const GlFunctions* gl_;
  ShaderProgram terrain_;
  ShaderProgram sky_;
  GLuint no_vertices_ = 0;  ///< The core profile demands a vertex array even where there is no vertex.
};

}  // namespace tintree::render
