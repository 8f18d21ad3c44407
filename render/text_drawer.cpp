#include "render/text_drawer.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "render/font.h"

namespace tintree::render {
namespace {

struct Vertex {
  glm::vec2 at_px;
  glm::vec2 texel;
  glm::vec4 color;
};
constexpr GLint kAttributes[] = {2, 2, 4};

/// Stands for an area without a character where the atlas' corners are wanted.
constexpr glm::vec2 kPlain{-1e6F, 0};

/// Two triangles.
void add_area(std::vector<Vertex>& out, glm::vec2 from, glm::vec2 to, glm::vec2 texel_from, glm::vec2 texel_to,
              const glm::vec4& color) {
  const std::array<Vertex, 4> corners{{{from, texel_from, color},
                                       {{to.x, from.y}, {texel_to.x, texel_from.y}, color},
                                       {{from.x, to.y}, {texel_from.x, texel_to.y}, color},
                                       {to, texel_to, color}}};
  for (const std::size_t i : {0, 1, 2, 2, 1, 3}) out.push_back(corners[i]);
}

void add_line(std::vector<Vertex>& out, const TextLine& line, float size_px) {
  const Font& font = overlay_font();
  const float scale = size_px / static_cast<float>(font.size_px);
  const glm::vec2 cell(font.cell_px[0], font.cell_px[1]);
  glm::vec2 at = line.at_px - scale * static_cast<float>(font.margin_px);
  for (std::string_view rest = line.text; !rest.empty(); at.x += scale * font.advance_px) {
    const auto character = static_cast<int>(take_character(rest));
    if (character == 0) continue;
    const glm::vec2 texel(character % font.columns * font.cell_px[0], character / font.columns * font.cell_px[1]);
    add_area(out, at, at + scale * cell, texel, texel + cell, line.color);
  }
}

GLuint make_atlas(const GlFunctions& gl) {
  const Font& font = overlay_font();
  GLuint out = 0;
  gl.GenTextures(1, &out);
  gl.BindTexture(GL_TEXTURE_2D, out);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, font.columns * font.cell_px[0], font.rows * font.cell_px[1], 0, GL_RED,
                GL_UNSIGNED_BYTE, font.distances.data());
  for (const GLenum edge : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    gl.TexParameteri(GL_TEXTURE_2D, edge, GL_CLAMP_TO_EDGE);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    gl.TexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  return out;
}

}  // namespace

glm::vec2 character_px(float size_px) {
  const Font& font = overlay_font();
  const float scale = size_px / static_cast<float>(font.size_px);
  return {scale * font.advance_px, scale * font.line_px};
}

Expected<TextDrawer> TextDrawer::create(const GlFunctions& gl) {
  auto program = ShaderProgram::create(gl, "text.vert.glsl", "text.frag.glsl");
  if (!program) return tl::unexpected(program.error());
  return TextDrawer(gl, std::move(*program));
}

TextDrawer::TextDrawer(const GlFunctions& gl, ShaderProgram program)
    : gl_(&gl), program_(std::move(program)), atlas_(make_atlas(gl)), stream_(gl, kAttributes) {}

TextDrawer::TextDrawer(TextDrawer&& other) noexcept
    : gl_(other.gl_),
      program_(std::move(other.program_)),
      atlas_(std::exchange(other.atlas_, 0)),
      stream_(std::move(other.stream_)) {}

TextDrawer::~TextDrawer() {
  if (atlas_ != 0) gl_->DeleteTextures(1, &atlas_);
}

void TextDrawer::draw(glm::ivec2 picture_px, std::span<const TextPanel> panels, std::span<const TextLine> lines,
                      float size_px) const {
  std::vector<Vertex> vertices;
  for (const TextPanel& p : panels) add_area(vertices, p.from_px, p.to_px, kPlain, kPlain, p.color);
  for (const TextLine& line : lines) add_line(vertices, line, size_px);
  if (vertices.empty()) return;
  gl_->Viewport(0, 0, picture_px.x, picture_px.y);
  gl_->Disable(GL_DEPTH_TEST);  // Which keeps the depths from being written too.
  gl_->Enable(GL_BLEND);
  gl_->BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  program_.use();
  const Font& font = overlay_font();
  gl_->Uniform3f(program_.uniform("picture_px"), static_cast<float>(picture_px.x), static_cast<float>(picture_px.y), 0);
  gl_->Uniform1f(program_.uniform("outline_px"),
                 2 * static_cast<float>(font.margin_px) * size_px / static_cast<float>(font.size_px));
  gl_->Uniform1i(program_.uniform("atlas"), 0);
  gl_->ActiveTexture(GL_TEXTURE0);
  gl_->BindTexture(GL_TEXTURE_2D, atlas_);
  stream_.draw(GL_TRIANGLES, std::span<const Vertex>(vertices));
  gl_->Disable(GL_BLEND);
}

}  // namespace tintree::render
