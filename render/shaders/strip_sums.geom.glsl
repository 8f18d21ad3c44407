#version 330 core
// Adds a triangle's normal to its corners', each of which has a texel, with the weights of cache/drawable_tile.h.
layout(triangles) in;
layout(points, max_vertices = 3) out;
flat in uint id[];
flat out vec3 weighted;

uniform int xy_bits;
uniform vec4 axes;        // east and north of a step of x, and of a step of y, metres
uniform float height_m;   // of a word's unit
uniform float texels;     // across

ivec3 corner(int i) {
  uint word = id[i % 3];
  uint mask = (1u << xy_bits) - 1u;
  return ivec3(word & mask, word >> xy_bits & mask, (word & 0x7fffffffu) >> (2 * xy_bits));
}

vec3 metres(ivec3 d) { return vec3(float(d.x) * axes.xy + float(d.y) * axes.zw, float(d.z) * height_m); }

void main() {
  if (id[0] == id[1]) return;
  for (int i = 0; i < 3; ++i) {
    ivec3 at = corner(i);
    vec3 a = metres(corner(i + 1) - at);
    vec3 b = metres(corner(i + 2) - at);
    weighted = cross(a, b) / (dot(a, a) * dot(b, b));
    gl_Position = vec4((2.0 * vec2(at.xy) + 1.0) / texels - 1.0, 0.0, 1.0);
    EmitVertex();
    EndPrimitive();
  }
}
