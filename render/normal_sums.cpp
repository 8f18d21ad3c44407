#include "render/normal_sums.h"

#include <cmath>

#include "render/square_texture.h"

namespace tintree::render {
namespace {

constexpr Texels kSums{GL_RGBA32F, GL_RGBA, GL_FLOAT, GL_NEAREST};

}  // namespace

Expected<NormalSums> NormalSums::create(const GlFunctions& gl, const ShaderStage& vertex) {
  auto program = ShaderProgram::link(gl, std::array{vertex, ShaderStage{GL_GEOMETRY_SHADER, "normal_sums.geom.glsl"},
                                                    ShaderStage{GL_FRAGMENT_SHADER, "normal_sums.frag.glsl"}});
  if (!program) return tl::unexpected(program.error());
  return NormalSums(gl, std::move(*program));
}

NormalSums::NormalSums(const GlFunctions& gl, ShaderProgram program) : gl_(&gl), program_(std::move(program)) {
  gl_->GenFramebuffers(1, &framebuffer_);
}

NormalSums::NormalSums(NormalSums&& other) noexcept
    : gl_(other.gl_), program_(std::move(other.program_)), framebuffer_(std::exchange(other.framebuffer_, 0)) {}

NormalSums::~NormalSums() {
  if (framebuffer_ != 0) gl_->DeleteFramebuffers(1, &framebuffer_);
}

GLuint NormalSums::begin(const codec::GridFrame& frame, int z_shift, int places) const {
  const GlFunctions& gl = *gl_;
  gl.Disable(GL_DEPTH_TEST);
  gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  gl.ActiveTexture(GL_TEXTURE0);
  const GLuint out = make_square_texture(gl, kSums, places, nullptr);
  const double step = std::ldexp(1.0, frame.xy_shift);
  const auto metres = [&](double axis, double spacing_m) { return static_cast<float>(axis * spacing_m * step); };
  gl.Uniform4f(program_.uniform("axes"), metres(frame.axes.column[0], frame.dx_m),
               metres(frame.axes.column[1], frame.dx_m), metres(frame.axes.row[0], frame.dy_m),
               metres(frame.axes.row[1], frame.dy_m));
  gl.Uniform1f(program_.uniform("height_m"), static_cast<float>(std::ldexp(frame.z_step_m, z_shift)));
  gl.Uniform1f(program_.uniform("texels"), static_cast<float>(places));
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, out, 0);
  gl.Viewport(0, 0, places, places);
  gl.ClearColor(0, 0, 0, 0);
  gl.Clear(GL_COLOR_BUFFER_BIT);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ONE);
  return out;
}

void NormalSums::end() const {
  gl_->Disable(GL_BLEND);
  gl_->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, 0, 0);
}

}  // namespace tintree::render
