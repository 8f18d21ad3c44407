#include "render/line_drawer.h"

#include <cstddef>
#include <utility>

#include <glm/gtc/type_ptr.hpp>

namespace tintree::render {
namespace {

struct Vertex {
  glm::vec3 from_eye;
  glm::vec4 color;
};
constexpr GLint kAttributes[] = {3, 4};

}  // namespace

void add_box(std::vector<WorldLine>& lines, const cache::Box& box, const glm::vec4& color) {
  const auto corner = [&](unsigned bits) {
    return glm::dvec3((bits & 1U) != 0 ? box.max[0] : box.min[0], (bits & 2U) != 0 ? box.max[1] : box.min[1],
                      (bits & 4U) != 0 ? box.max[2] : box.min[2]);
  };
  for (unsigned bits = 0; bits < 8; ++bits) {
    for (unsigned axis = 1; axis < 8; axis *= 2)
      if ((bits & axis) == 0) lines.push_back({corner(bits), corner(bits | axis), color});
  }
}

void add_view(std::vector<WorldLine>& lines, const Camera& camera, double depth_m, const glm::vec4& color) {
  const double w = camera.width_px;
  const double h = camera.height_px;
  const auto end = [&](double x_px, double y_px) { return camera.eye + camera.ray(x_px, y_px) * depth_m; };
  const glm::dvec3 ends[] = {end(0, 0), end(w, 0), end(w, h), end(0, h)};
  for (std::size_t i = 0; i < 4; ++i) {
    lines.push_back({camera.eye, ends[i], color});
    lines.push_back({ends[i], ends[(i + 1) % 4], color});
  }
}

Expected<LineDrawer> LineDrawer::create(const GlFunctions& gl) {
  auto program = ShaderProgram::create(gl, "line.vert.glsl", "line.frag.glsl");
  if (!program) return tl::unexpected(program.error());
  return LineDrawer(gl, std::move(*program));
}

LineDrawer::LineDrawer(const GlFunctions& gl, ShaderProgram program)
    : gl_(&gl), program_(std::move(program)), stream_(gl, kAttributes) {}

void LineDrawer::draw(const OffscreenTarget& target, const Camera& camera, double near_m,
                      std::span<const WorldLine> lines) const {
  if (lines.empty()) return;
  std::vector<Vertex> vertices;
  vertices.reserve(2 * lines.size());
  for (const WorldLine& line : lines) {
    vertices.push_back({glm::vec3(line.from - camera.eye), line.color});
    vertices.push_back({glm::vec3(line.to - camera.eye), line.color});
  }
  target.bind();
  if (gl_->ClipControl != nullptr) gl_->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl_->Enable(GL_DEPTH_TEST);
  gl_->DepthFunc(GL_GREATER);
  gl_->DepthMask(GL_FALSE);
  gl_->Enable(GL_BLEND);
  gl_->BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  program_.use();
  const glm::mat4 to_clip(camera.projection(near_m, gl_->ClipControl != nullptr) * camera.view_rotation());
  gl_->UniformMatrix4fv(program_.uniform("eye_to_clip"), 1, GL_FALSE, glm::value_ptr(to_clip));
  stream_.draw(GL_LINES, std::span<const Vertex>(vertices));
  gl_->Disable(GL_BLEND);
  gl_->DepthMask(GL_TRUE);
}

}  // namespace tintree::render
