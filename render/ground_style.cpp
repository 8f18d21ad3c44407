#include "render/ground_style.h"

#include <array>

namespace tintree::render {

Expected<ShaderProgram> make_ground_program(const GlFunctions& gl, std::string_view vertex_name) {
  const std::array stages{ShaderStage{GL_VERTEX_SHADER, vertex_name, "ground_common.glsl", "#version 330 core\n"},
                          ShaderStage{GL_FRAGMENT_SHADER, "terrain.frag.glsl"}};
  return ShaderProgram::link(gl, stages);
}

void set_tile_look(const GlFunctions& gl, const ShaderProgram& program, const GpuTilePool& pool, const GpuTile& tile,
                   const cache::TileNode& node, const DrawTile& drawn, const Style& style) {
  GpuPictures pictures = tile.pictures;
  if (pictures.directions == 0) pictures.directions = tile.relief.normals;
  gl.Uniform1i(program.uniform("normal_mapped"), pictures.directions != 0 ? 1 : 0);
  pool.textures().bind(pictures);
  if (pool.fine_textures().in_use()) pool.fine_textures().set_look(program, drawn);
  const glm::vec4 tint = tile_tint(style.tint, node, drawn, style.allowed_px);
  gl.Uniform4f(program.uniform("tile_tint"), tint.r, tint.g, tint.b, tint.a);
}

}  // namespace tintree::render
