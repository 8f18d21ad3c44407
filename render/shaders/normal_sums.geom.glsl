#version 330 core
// Adds a triangle's normal to its corners', each of which has a texel, with the weights of cache/drawable_tile.h.
layout(triangles) in;
layout(points, max_vertices = 3) out;
flat in ivec3 address[];
flat out vec3 weighted;

uniform vec4 axes;        // east and north of a step of x, and of a step of y, metres
uniform float height_m;   // of a unit of height
uniform float texels;     // across

vec3 metres(ivec3 d) { return vec3(float(d.x) * axes.xy + float(d.y) * axes.zw, float(d.z) * height_m); }

void main() {
  if (address[0] == address[1]) return;
  for (int i = 0; i < 3; ++i) {
    ivec3 at = address[i];
    vec3 a = metres(address[(i + 1) % 3] - at);
    vec3 b = metres(address[(i + 2) % 3] - at);
    weighted = cross(a, b) / (dot(a, a) * dot(b, b));
    gl_Position = vec4((2.0 * vec2(at.xy) + 1.0) / texels - 1.0, 0.0, 1.0);
    EmitVertex();
    EndPrimitive();
  }
}
