#include "render/scalar_drawer.h"

#include <array>
#include <cmath>
#include <utility>

#include <glm/gtc/type_ptr.hpp>

#include "render/scalar_placement.h"

namespace tintree::render {

Expected<ScalarDrawer> ScalarDrawer::create(const GlFunctions& gl) {
  constexpr const char* kVersion = "#version 330 core\n";
  const std::array stages{ShaderStage{GL_VERTEX_SHADER, "scalar_draw.vert.glsl", "ground_common.glsl", kVersion},
                          ShaderStage{GL_VERTEX_SHADER, "scalar_word.glsl", {}, kVersion},
                          ShaderStage{GL_FRAGMENT_SHADER, "terrain.frag.glsl"}};
  auto program = ShaderProgram::link(gl, stages);
  if (!program) return tl::unexpected(program.error());
  return ScalarDrawer(gl, std::move(*program));
}

ScalarDrawer::ScalarDrawer(const GlFunctions& gl, ShaderProgram program) : gl_(&gl), program_(std::move(program)) {}

void ScalarDrawer::draw(const Camera& camera, Trees trees, std::span<const DrawTile> draws, GpuTilePool& pool,
                        const Style& style, DrawStats& stats) const {
  for (const DrawTile& d : draws) {
    const cache::TileNode& node = trees[d.tree]->nodes()[d.node];
    const GpuTile* tile = pool.use({node.id, d.tree});
    if (tile == nullptr || !tile->quantizer) continue;
    const GpuMesh& mesh = tile->quantized;
    const cache::QuantizedFormat& format = tile->quantizer->format;
    const ScalarPlacement at = place_scalar(tile->frame, format, {camera.eye.x, camera.eye.y, camera.eye.z});
    const auto across = static_cast<double>(trees[d.tree]->layout().cells_across(node.id.level));
    const auto& [west, north, east, south] = format.borders;
    gl_->UniformMatrix4fv(program_.uniform("index_to_eye"), 1, GL_FALSE, glm::value_ptr(at.index_to_eye));
    gl_->UniformMatrix4fv(program_.uniform("lattice_to_eye"), 1, GL_FALSE, glm::value_ptr(at.lattice_to_eye));
    gl_->Uniform4i(program_.uniform("corner_and_shift"), at.corner.x, at.corner.y, at.corner.z, at.samples_shift);
    gl_->Uniform4i(program_.uniform("borders"), west, north, east, south);
    gl_->Uniform1f(program_.uniform("tile_share"), static_cast<float>(std::ldexp(1.0, tile->frame.xy_shift) / across));
    set_quantizer(*gl_, program_, *tile->quantizer);
    set_tile_look(*gl_, program_, pool, *tile, node, d, style);
    gl_->BindVertexArray(mesh.vertex_array);
    const auto surface = static_cast<GLsizei>(3 * mesh.surface_triangles);
    gl_->DrawElementsBaseVertex(GL_TRIANGLES, style.skirts ? mesh.index_count : surface, mesh.index_type,
                                reinterpret_cast<const void*>(mesh.index_offset), mesh.base_vertex);
    ++stats.tiles;
    ++stats.draw_calls;
    stats.triangles += mesh.surface_triangles;
  }
}

}  // namespace tintree::render
