#version 330 core

in vec2 place;
flat in vec4 text_color;

uniform sampler2D atlas;      // distance to the outline: 0.5 on it, more inside
uniform float outline_px;     // pixels of the picture from the atlas' 0 to its 1

out vec4 color;

void main() {
  float cover = 1.0;
  // At the edge of a character's area a sample may lie a few texels outside it.
  if (place.x > -1000.0) {
    float distance_px = (texture(atlas, place / vec2(textureSize(atlas, 0))).r - 128.0 / 255.0) * outline_px;
    cover = clamp(distance_px + 0.5, 0.0, 1.0);
  }
  color = vec4(text_color.rgb, text_color.a * cover);
}
