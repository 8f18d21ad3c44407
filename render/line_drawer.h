#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "cache/tile_bounds.h"
#include "codec/error.h"
#include "render/camera.h"
#include "render/gl_functions.h"
#include "render/offscreen_target.h"
#include "render/shader_program.h"
#include "render/vertex_stream.h"

namespace tintree::render {

/// A straight line in the world frame, metres; colour sRGB and opacity, 0 to 1.
struct WorldLine {
  glm::dvec3 from;
  glm::dvec3 to;
  glm::vec4 color{1, 1, 1, 1};
};

/// Adds the twelve edges of a box.
void add_box(std::vector<WorldLine>& lines, const cache::Box& box, const glm::vec4& color);

/// Adds the eye's view as a pyramid as long as `depth_m`.
void add_view(std::vector<WorldLine>& lines, const Camera& camera, double depth_m, const glm::vec4& color);

/// Draws lines into a picture of the ground, hidden by it where it is in front. Lives and dies while its
/// context is current; not thread-safe.
class LineDrawer {
 public:
  /// `gl` must outlive it. Fails with kIo when the driver refuses a shader.
  static Expected<LineDrawer> create(const GlFunctions& gl);

  /// `near_m`: as the ground was drawn with (Renderer::near_m).
  void draw(const OffscreenTarget& target, const Camera& camera, double near_m, std::span<const WorldLine> lines) const;

 private:
  LineDrawer(const GlFunctions& gl, ShaderProgram program);

  const GlFunctions* gl_;
  ShaderProgram program_;
  VertexStream stream_;
};

}  // namespace tintree::render
