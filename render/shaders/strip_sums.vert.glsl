#version 330 core
// For normal_sums.geom.glsl.
uniform int xy_bits;

flat out ivec3 address;

void main() {
  uint word = uint(gl_VertexID);
  uint mask = (1u << xy_bits) - 1u;
  address = ivec3(word & mask, word >> xy_bits & mask, (word & 0x7fffffffu) >> (2 * xy_bits));
}
