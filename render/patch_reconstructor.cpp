#include "render/patch_reconstructor.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "codec/wavelet_patch.h"
#include "render/square_texture.h"

namespace tintree::render {
namespace {

constexpr Texels kHeights{GL_R32I, GL_RED_INTEGER, GL_INT, GL_NEAREST};
constexpr Texels kBytes{GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, GL_NEAREST};
constexpr Texels kWords{GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, GL_NEAREST};

GLuint make_numbers(const GlFunctions& gl, const codec::PatchResidual& residual) {
  if (!residual.wide_numbers.empty())
    return make_square_texture(gl, kWords, residual.side, residual.wide_numbers.data());
  if (!residual.numbers.empty()) return make_square_texture(gl, kBytes, residual.side, residual.numbers.data());
  const std::vector<std::uint8_t> none(static_cast<std::size_t>(residual.side) *
                                       static_cast<std::size_t>(residual.side));
  return make_square_texture(gl, kBytes, residual.side, none.data());
}

int nodes(const cache::TileRelief& relief) { return relief.residual.side - 2 * codec::kPatchMargin + 1; }

std::size_t squared(int size) { return static_cast<std::size_t>(size) * static_cast<std::size_t>(size); }

}  // namespace

Expected<std::unique_ptr<PatchReconstructor>> PatchReconstructor::create(const GlFunctions& gl) {
  auto heights = ShaderProgram::create(gl, "whole.vert.glsl", "patch_heights.frag.glsl");
  if (!heights) return tl::unexpected(heights.error());
  auto normals = ShaderProgram::create(gl, "whole.vert.glsl", "patch_normals.frag.glsl");
  if (!normals) return tl::unexpected(normals.error());
  return std::unique_ptr<PatchReconstructor>(new PatchReconstructor(gl, std::move(*heights), std::move(*normals)));
}

PatchReconstructor::PatchReconstructor(const GlFunctions& gl, ShaderProgram heights, ShaderProgram normals)
    : gl_(&gl), heights_(std::move(heights)), normals_(std::move(normals)) {
  gl_->GenFramebuffers(1, &framebuffer_);
  gl_->GenVertexArrays(1, &no_vertices_);
}

PatchReconstructor::~PatchReconstructor() {
  gl_->DeleteFramebuffers(1, &framebuffer_);
  gl_->DeleteVertexArrays(1, &no_vertices_);
}

std::size_t PatchReconstructor::bytes(const cache::TileRelief& relief) {
  return 4 * squared(nodes(relief)) + (relief.has_children ? 4 * squared(relief.residual.side) : 0);
}

GpuRelief PatchReconstructor::make(const cache::TileRelief& relief, GLuint parent_heights) const {
  if (relief.parent && parent_heights == 0) return {};
  GpuRelief out;
  out.heights = make_heights(relief, parent_heights);
  out.normals = make_normals(relief, out.heights);
  out.bytes = bytes(relief);
  if (!relief.has_children) {
    gl_->DeleteTextures(1, &out.heights);
    out.heights = 0;
  }
  return out;
}

GLuint PatchReconstructor::make_heights(const cache::TileRelief& relief, GLuint parent_heights) const {
  const codec::PatchResidual& residual = relief.residual;
  const int own = residual.side - 2 * codec::kPatchMargin;
  gl_->ActiveTexture(GL_TEXTURE0);
  const GLuint out = make_square_texture(*gl_, kHeights, residual.side, nullptr);
  const GLuint numbers = make_numbers(*gl_, residual);
  gl_->ActiveTexture(GL_TEXTURE1);
  gl_->BindTexture(GL_TEXTURE_2D, parent_heights);
  heights_.use();
  gl_->Uniform1i(heights_.uniform("numbers"), 0);
  gl_->Uniform1i(heights_.uniform("parent_heights"), 1);
  gl_->Uniform1i(heights_.uniform("low"), residual.low);
  gl_->Uniform1i(heights_.uniform("step"), residual.step);
  gl_->Uniform1i(heights_.uniform("has_parent"), relief.parent ? 1 : 0);
  gl_->Uniform1i(heights_.uniform("east"), (relief.quadrant & 1) * own);
  gl_->Uniform1i(heights_.uniform("south"), (relief.quadrant >> 1) * own);
  fill(out, residual.side);
  gl_->DeleteTextures(1, &numbers);
  return out;
}

GLuint PatchReconstructor::make_normals(const cache::TileRelief& relief, GLuint heights) const {
  const auto& [west, north, east, south] = relief.on_raster;
  const auto& s = relief.slopes;
  gl_->ActiveTexture(GL_TEXTURE0);
  const GLuint out = make_square_texture(*gl_, kNormalTexels, nodes(relief), nullptr);
  GLuint surface = 0;
  if (!relief.surface.empty()) surface = make_square_texture(*gl_, kBytes, relief.residual.side, relief.surface.data());
  gl_->BindTexture(GL_TEXTURE_2D, surface);
  gl_->ActiveTexture(GL_TEXTURE1);
  gl_->BindTexture(GL_TEXTURE_2D, heights);
  normals_.use();
  gl_->Uniform1i(normals_.uniform("surface"), 0);
  gl_->Uniform1i(normals_.uniform("heights"), 1);
  gl_->Uniform1i(normals_.uniform("masked"), surface != 0 ? 1 : 0);
  gl_->Uniform4f(normals_.uniform("on_raster"), static_cast<float>(west), static_cast<float>(north),
                 static_cast<float>(east), static_cast<float>(south));
  gl_->Uniform1f(normals_.uniform("node_shift"), relief.node_shift);
  gl_->Uniform4f(normals_.uniform("slopes"), s[0], s[1], s[2], s[3]);
  fill(out, nodes(relief));
  gl_->DeleteTextures(1, &surface);
  return out;
}

/// Draws over the whole of a texture by the program in use.
void PatchReconstructor::fill(GLuint texture, int size) const {
  GLint framebuffer = 0;
  std::array<GLint, 4> viewport{};
  gl_->GetIntegerv(GL_FRAMEBUFFER_BINDING, &framebuffer);
  gl_->GetIntegerv(GL_VIEWPORT, viewport.data());
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  gl_->Viewport(0, 0, size, size);
  gl_->Disable(GL_DEPTH_TEST);
  gl_->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  gl_->BindVertexArray(no_vertices_);
  gl_->DrawArrays(GL_TRIANGLES, 0, 3);
  gl_->BindVertexArray(0);
  gl_->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, 0, 0);
  gl_->BindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(framebuffer));
  gl_->Viewport(viewport[0], viewport[1], viewport[2], viewport[3]);
}

}  // namespace tintree::render
