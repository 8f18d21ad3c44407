#version 330 core

layout(location = 0) in uvec4 packed_address;  // cache/drawable_tile.h, DrawVertex
layout(location = 1) in vec2 normal_xy;

uniform mat4 address_to_eye;   // grid addresses to metres east, north, up of the eye
uniform mat4 eye_to_clip;
uniform float skirt_slope;     // metres of skirt a metre of distance
uniform float eye_rise;        // metres of the eye above the lowest ground

out vec3 from_eye;
out vec3 normal;
out float rise;                // metres above the lowest ground

void main() {
  uint high = packed_address.w;
  uint skirt_sides = high & 15u;
  vec3 address = vec3(packed_address.xyz | uvec3(high >> 4 & 7u, high >> 7 & 7u, high >> 10) << 16);
  vec3 position = (address_to_eye * vec4(address, 1.0)).xyz;
  rise = position.z + eye_rise;
  if (skirt_sides != 0u) {
    // Down by what a gap can measure, and half of that outward, under the neighbour, so that rounding
    // leaves no pinhole where the border is seen from above.
    float reach = skirt_slope * length(position);
    float across = float((skirt_sides >> 1) & 1u) - float(skirt_sides & 1u);
    float down = float((skirt_sides >> 3) & 1u) - float((skirt_sides >> 2) & 1u);
    vec2 outward = across * normalize(address_to_eye[0].xy) + down * normalize(address_to_eye[1].xy);
    position += reach * vec3(0.5 * outward, -1.0);
  }
  from_eye = position;
  normal = vec3(normal_xy, sqrt(max(0.0, 1.0 - dot(normal_xy, normal_xy))));
  gl_Position = eye_to_clip * vec4(position, 1.0);
}
