#pragma once

#include <span>
#include <string>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "codec/error.h"
#include "render/gl_functions.h"
#include "render/shader_program.h"
#include "render/vertex_stream.h"

namespace tintree::render {

/// One line of text. Places are pixels from the picture's left and top; colours sRGB and opacity, 0 to 1.
struct TextLine {
  glm::vec2 at_px{0, 0};  ///< Upper left corner.
  std::string text;       ///< UTF-8, of the characters of render/font.h.
  glm::vec4 color{1, 1, 1, 1};
};

/// A plain area behind text.
struct TextPanel {
  glm::vec2 from_px{0, 0};
  glm::vec2 to_px{0, 0};
  glm::vec4 color{0, 0, 0, 0.5};
};

/// Width of a character and height of a line at a font size, pixels.
glm::vec2 character_px(float size_px);

/// Draws text over a picture. Lives and dies while its context is current; not thread-safe.
class TextDrawer {
 public:
  /// `gl` must outlive it. Fails with kIo when the driver refuses a shader.
  static Expected<TextDrawer> create(const GlFunctions& gl);

  TextDrawer(TextDrawer&& other) noexcept;
  TextDrawer& operator=(TextDrawer&&) = delete;
  ~TextDrawer();

  /// Over what the frame that is drawn into holds, panels first; its depths stay as they are. `picture_px`: its width
  /// and height; `size_px`: height of an em.
  void draw(glm::ivec2 picture_px, std::span<const TextPanel> panels, std::span<const TextLine> lines,
            float size_px) const;

 private:
  TextDrawer(const GlFunctions& gl, ShaderProgram program);

  const GlFunctions* gl_;
  ShaderProgram program_;
  GLuint atlas_ = 0;
  VertexStream stream_;
};

}  // namespace tintree::render
