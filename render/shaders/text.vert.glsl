#version 330 core

layout(location = 0) in vec2 at_px;   // from the left and the top
layout(location = 1) in vec2 texel;   // of the font's atlas; far under 0: a plain area
layout(location = 2) in vec4 tone;

uniform vec3 picture_px;              // width and height

out vec2 place;
flat out vec4 text_color;

void main() {
  place = texel;
  text_color = tone;
  gl_Position = vec4(2.0 * at_px.x / picture_px.x - 1.0, 1.0 - 2.0 * at_px.y / picture_px.y, 0.0, 1.0);
}
