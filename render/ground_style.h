#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <glm/vec3.hpp>

#include "cache/tile_bounds.h"
#include "codec/error.h"
#include "render/gl_functions.h"
#include "render/gpu_tile_pool.h"
#include "render/lod_cut.h"
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
  bool skirts = true;    ///< Off only to see the gaps that they fill.
  bool stitches = true;  ///< Between nested tiles; off only to see the gaps that they fill.
};

/// What a frame drew.
struct DrawStats {
  std::uint32_t tiles = 0;
  std::uint32_t draw_calls = 0;
  std::uint64_t triangles = 0;  ///< Of surfaces; skirts are not counted.
  /// Tiles that an impostor stood in for, and triangles drawn into a new one.
  std::uint32_t impostor_tiles = 0;
  std::uint64_t impostor_triangles = 0;

  /// Counts a tile that one call has drawn.
  void add_tile(std::uint64_t surface_triangles) {
    ++tiles;
    ++draw_calls;
    triangles += surface_triangles;
  }
};

/// A program of a kind of tiles: their vertex shader, behind what all share, another if its kind has one of its own
/// (`words_name`), and the ground's fragment shader.
Expected<ShaderProgram> make_ground_program(const GlFunctions& gl, std::string_view vertex_name,
                                            std::string_view words_name = {});

/// Tells the program in use what a tile looks like: its pictures, how they lie on it, and its tint.
void set_tile_look(const GlFunctions& gl, const ShaderProgram& program, const GpuTilePool& pool, const GpuTile& tile,
                   Trees trees, const DrawTile& drawn, const Style& style);

/// Draws a mesh, whose vertex array is bound, with its skirt if `style` has skirts.
void draw_mesh(const GlFunctions& gl, const GpuMesh& mesh, const Style& style, DrawStats& stats);

}  // namespace tintree::render
