#version 330 core
// Draws the words of render/strip_decoder as indices: the index is the vertex (Dick et al. 2009, section 6).

uniform mat4 matrix;      // from (x, y, height) in the payload's units
uniform int levels;
uniform float highest;    // the height that is white
uniform float foot_depth; // of skirts, in the units of height

out vec4 line_color;

void main() {
  uint word = uint(gl_VertexID);
  uint mask = (1u << (levels + 1)) - 1u;
  float height = float((word & 0x7fffffffu) >> (2 * levels + 2));
  line_color = vec4(vec3(height / highest), 1.0);
  if (word >> 31 != 0u) height -= foot_depth;
  gl_Position = matrix * vec4(float(word & mask), float(word >> (levels + 1) & mask), height, 1.0);
}
