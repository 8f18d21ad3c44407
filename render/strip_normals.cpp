#include "render/strip_normals.h"

#include <array>
#include <utility>

#include "render/square_texture.h"

namespace tintree::render {
namespace {

/// Texels from side to side of the tile: a power of two, so that places lie on texels or halfway between.
int intervals(const codec::StripHead& head) {
  int out = 1 << head.levels;
  while (out > 2 && std::int64_t{out} * out > 2 * std::int64_t{head.triangles}) out /= 2;
  return out;
}

}  // namespace

Expected<std::unique_ptr<StripNormals>> StripNormals::create(const GlFunctions& gl) {
  auto sums = NormalSums::create(gl, {GL_VERTEX_SHADER, "strip_sums.vert.glsl"});
  if (!sums) return tl::unexpected(sums.error());
  auto normals = ShaderProgram::create(gl, "strip_normals.vert.glsl", "strip_normals.frag.glsl");
  if (!normals) return tl::unexpected(normals.error());
  return std::unique_ptr<StripNormals>(new StripNormals(gl, std::move(*sums), std::move(*normals)));
}

StripNormals::StripNormals(const GlFunctions& gl, NormalSums sums, ShaderProgram normals)
    : gl_(&gl), sums_(std::move(sums)), normals_(std::move(normals)) {
  gl_->GenFramebuffers(1, &framebuffer_);
}

StripNormals::~StripNormals() { gl_->DeleteFramebuffers(1, &framebuffer_); }

std::size_t StripNormals::bytes(const codec::StripHead& head) {
  const auto texels = static_cast<std::size_t>(intervals(head)) + 1;
  return 4 * texels * texels;
}

GLuint StripNormals::make(const codec::StripHead& head, const codec::GridFrame& frame, GLuint vertex_array,
                          std::uint32_t first_word) const {
  const GlFunctions& gl = *gl_;
  const TargetGuard guard(gl);
  const auto draw = [&](GLenum kind) {
    gl.DrawElements(kind, static_cast<GLsizei>(3 * head.triangles), GL_UNSIGNED_INT,
                    reinterpret_cast<const void*>(std::size_t{4} * first_word));
  };

  const int places = (1 << head.levels) + 1;
  gl.BindVertexArray(vertex_array);
  sums_.program().use();
  gl.Uniform1i(sums_.program().uniform("xy_bits"), head.levels + 1);
  const GLuint sums = sums_.make(frame, head.z_shift, places, [&] { draw(GL_TRIANGLES); });

  const int texels = intervals(head) + 1;
  const GLuint out = make_square_texture(gl, kNormalTexels, texels, nullptr);
  gl.BindTexture(GL_TEXTURE_2D, sums);
  normals_.use();
  gl.Uniform1i(normals_.uniform("sums"), 0);
  gl.Uniform1i(normals_.uniform("xy_bits"), head.levels + 1);
  gl.Uniform1f(normals_.uniform("spacing"), static_cast<float>(texels - 1) / static_cast<float>(places - 1));
  gl.Uniform1f(normals_.uniform("texels"), static_cast<float>(texels));
  draw_into(out, texels, vertex_array);
  // Points too, so that a hole's rim, between texels, has normals beyond it.
  draw(GL_POINTS);
  draw(GL_TRIANGLES);

  gl.BindVertexArray(0);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, 0, 0);
  gl.DeleteTextures(1, &sums);
  return out;
}

/// Binds what is to be drawn into, cleared, and what is to be drawn.
void StripNormals::draw_into(GLuint texture, int texels, GLuint vertex_array) const {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  gl_->Viewport(0, 0, texels, texels);
  gl_->ClearColor(0, 0, 0, 0);
  gl_->Clear(GL_COLOR_BUFFER_BIT);
  gl_->BindVertexArray(vertex_array);
}

}  // namespace tintree::render
