#include "render/scalar_drawer.h"

#include <utility>

#include <glm/gtc/type_ptr.hpp>

#include "render/scalar_placement.h"

namespace tintree::render {

Expected<ScalarDrawer> ScalarDrawer::create(const GlFunctions& gl) {
  auto program = make_ground_program(gl, "scalar_draw.vert.glsl", "scalar_word.glsl");
  if (!program) return tl::unexpected(program.error());
  return ScalarDrawer(gl, std::move(*program));
}

ScalarDrawer::ScalarDrawer(const GlFunctions& gl, ShaderProgram program) : gl_(&gl), program_(std::move(program)) {}

void ScalarDrawer::draw(const Camera& camera, Trees trees, std::span<const DrawTile> draws, GpuTilePool& pool,
                        const Style& style, DrawStats& stats) const {
  for (const DrawTile& d : draws) {
    const GpuTile* tile = pool.use({trees[d.tree]->nodes()[d.node].id, d.tree});
    if (tile == nullptr || !tile->quantizer) continue;
    const cache::QuantizedFormat& format = tile->quantizer->format;
    const ScalarPlacement at = place_scalar(tile->frame, format, {camera.eye.x, camera.eye.y, camera.eye.z});
    const auto& [west, north, east, south] = format.borders;
    gl_->UniformMatrix4fv(program_.uniform("index_to_eye"), 1, GL_FALSE, glm::value_ptr(at.index_to_eye));
    gl_->UniformMatrix4fv(program_.uniform("lattice_to_eye"), 1, GL_FALSE, glm::value_ptr(at.lattice_to_eye));
    gl_->Uniform4i(program_.uniform("corner_and_shift"), at.corner.x, at.corner.y, at.corner.z, at.samples_shift);
    gl_->Uniform4i(program_.uniform("borders"), west, north, east, south);
    set_quantizer(*gl_, program_, *tile->quantizer);
    set_tile_look(*gl_, program_, pool, *tile, trees, d, style);
    gl_->BindVertexArray(tile->quantized.vertex_array);
    draw_mesh(*gl_, tile->quantized, style, stats);
  }
}

}  // namespace tintree::render
