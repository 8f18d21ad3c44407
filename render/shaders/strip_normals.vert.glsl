#version 330 core
// A strip's words seen from above, the whole tile on the picture; what is drawn are its vertices' normals.
uniform sampler2D sums;   // of normals, a texel a place
uniform int xy_bits;
uniform float spacing;    // texels of the picture from a place to the next
uniform float texels;     // of the picture, across

out vec2 east_north;

void main() {
  uint word = uint(gl_VertexID);
  uint mask = (1u << xy_bits) - 1u;
  ivec2 place = ivec2(word & mask, word >> xy_bits & mask);
  vec3 sum = texelFetch(sums, place, 0).xyz;
  east_north = sum.xy / max(length(sum), 1e-30);
  // Those on the border are in the middle of a texel: a little beyond it, so that it is covered.
  gl_Position = vec4(((2.0 * spacing * vec2(place) + 1.0) / texels - 1.0) * (1.0 + 0.01 / texels), 0.0, 1.0);
}
