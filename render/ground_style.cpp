#include "render/ground_style.h"

#include <cmath>
#include <vector>

namespace tintree::render {

Expected<ShaderProgram> make_ground_program(const GlFunctions& gl, std::string_view vertex_name,
                                            std::string_view words_name) {
  constexpr const char* kVersion = "#version 330 core\n";
  std::vector<ShaderStage> stages{{GL_VERTEX_SHADER, vertex_name, "ground_common.glsl", kVersion},
                                  {GL_FRAGMENT_SHADER, "terrain.frag.glsl"}};
  if (!words_name.empty()) stages.push_back({GL_VERTEX_SHADER, words_name, {}, kVersion});
  return ShaderProgram::link(gl, stages);
}

void set_tile_look(const GlFunctions& gl, const ShaderProgram& program, const GpuTilePool& pool, const GpuTile& tile,
                   Trees trees, const DrawTile& drawn, const Style& style) {
  const cache::TileBounds& tree = *trees[drawn.tree];
  const cache::TileNode& node = tree.nodes()[drawn.node];
  const auto across = static_cast<double>(tree.layout().cells_across(node.id.level));
  gl.Uniform1f(program.uniform("tile_share"), static_cast<float>(std::ldexp(1.0, tile.frame.xy_shift) / across));
  GpuPictures pictures = tile.pictures;
  if (pictures.directions == 0) pictures.directions = tile.relief.normals;
  gl.Uniform1i(program.uniform("normal_mapped"), pictures.directions != 0 ? 1 : 0);
  pool.textures().bind(pictures);
  if (pool.fine_textures().in_use()) pool.fine_textures().set_look(program, drawn);
  const glm::vec4 tint = tile_tint(style.tint, node, drawn, style.allowed_px);
  gl.Uniform4f(program.uniform("tile_tint"), tint.r, tint.g, tint.b, tint.a);
}

void draw_mesh(const GlFunctions& gl, const GpuMesh& mesh, const Style& style, DrawStats& stats) {
  const auto surface = static_cast<GLsizei>(3 * mesh.surface_triangles);
  gl.DrawElementsBaseVertex(GL_TRIANGLES, style.skirts ? mesh.index_count : surface, mesh.index_type,
                            reinterpret_cast<const void*>(mesh.index_offset), mesh.base_vertex);
  stats.add_tile(mesh.surface_triangles);
}

}  // namespace tintree::render
