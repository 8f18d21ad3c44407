#include "render/strip_drawer.h"

#include <cmath>
#include <utility>

#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>

namespace tintree::render {

Expected<StripDrawer> StripDrawer::create(const GlFunctions& gl) {
  auto program = make_ground_program(gl, "strip_draw.vert.glsl");
  if (!program) return tl::unexpected(program.error());
  return StripDrawer(gl, std::move(*program));
}

StripDrawer::StripDrawer(const GlFunctions& gl, ShaderProgram program) : gl_(&gl), program_(std::move(program)) {}

void StripDrawer::draw(const Camera& camera, Trees trees, std::span<const DrawTile> draws, GpuTilePool& pool,
                       const Style& style, DrawStats& stats) const {
  for (const DrawTile& d : draws) {
    const GpuTile* tile = pool.use({trees[d.tree]->nodes()[d.node].id, d.tree});
    if (tile == nullptr || tile->strip.vertex_array == 0) continue;
    const GpuStrip& strip = tile->strip;
    const glm::mat4 matrix(glm::make_mat4(tile->frame.matrix({camera.eye.x, camera.eye.y, camera.eye.z}).data()));
    const auto& [west, north, east, south] = strip.borders;
    gl_->UniformMatrix4fv(program_.uniform("address_to_eye"), 1, GL_FALSE, glm::value_ptr(matrix));
    gl_->Uniform1i(program_.uniform("xy_bits"), strip.xy_bits);
    gl_->Uniform1f(program_.uniform("height_unit"), std::ldexp(1.0F, strip.z_shift));
    gl_->Uniform4i(program_.uniform("borders"), west, north, east, south);
    set_tile_look(*gl_, program_, pool, *tile, trees, d, style);
    gl_->BindVertexArray(strip.vertex_array);
    const std::uint32_t words = strip.triangle_words + (style.skirts ? strip.skirt_words : 0);
    gl_->DrawElements(GL_TRIANGLES, static_cast<GLsizei>(words), GL_UNSIGNED_INT,
                      reinterpret_cast<const void*>(std::size_t{4} * strip.first_word));
    stats.add_tile(strip.surface_triangles);
  }
}

}  // namespace tintree::render
