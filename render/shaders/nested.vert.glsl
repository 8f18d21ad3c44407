#version 330 core

// Tiles of method nested (Schneider and Westermann 2006). A triangle between two tiles has vertices of both, so all
// that belongs to a tile comes twice, and each vertex says whose it is.
layout(location = 0) in uvec2 packed_address;  // x and y; their upper bits and height (render/nested_drawer.h)
layout(location = 1) in vec4 coarse_rises;     // of the meshes of levels 0 to 3 at this vertex
layout(location = 2) in vec4 fine_rises;       // 4 to 7
layout(location = 3) in float other_tile;      // 1 for the second tile's

uniform mat4 address_to_eye[2];   // grid addresses to metres east, north, up of the eye
uniform mat4 eye_to_clip;
uniform vec4 low_levels[2];       // wanted at the box's lower corners, and at its upper ones (render/nested_lod.h)
uniform vec4 high_levels[2];
uniform vec4 box[2];              // an address's share of the box's width; height of its floor; a step's of its height
uniform vec4 coarse_units[2];     // height steps of a unit of the rises
uniform vec4 fine_units[2];
uniform float eye_rise;           // metres of the eye above the lowest ground

out vec3 from_eye;
out float rise;                   // metres above the lowest ground

void main() {
  int tile = other_tile > 0.5 ? 1 : 0;
  vec3 address = vec3(packed_address.x & 0xffffu | (packed_address.y >> 22 & 7u) << 16,
                      packed_address.x >> 16 | (packed_address.y >> 25 & 7u) << 16, packed_address.y & 0x3fffffu);
  vec4 b = box[tile];
  vec3 at = vec3(address.xy * b.x, (address.z - b.y) * b.z);
  vec4 corners = mix(low_levels[tile], high_levels[tile], at.z);
  vec2 sides = mix(corners.xz, corners.yw, at.x);
  float level = mix(sides.x, sides.y, at.y);
  // Forward differences of clamped ramps: the weights of the levels' heights.
  vec4 coarse = clamp(level - vec4(0.0, 1.0, 2.0, 3.0), 0.0, 1.0);
  vec4 fine = clamp(level - vec4(4.0, 5.0, 6.0, 7.0), 0.0, 1.0);
  vec4 coarse_weights = vec4(1.0, coarse.xyz) - coarse;
  vec4 fine_weights = vec4(coarse.w, fine.xyz) - fine;
  address.z += dot(coarse_weights, coarse_rises * coarse_units[tile]) + dot(fine_weights, fine_rises * fine_units[tile]);
  vec3 position = (address_to_eye[tile] * vec4(address, 1.0)).xyz;
  from_eye = position;
  rise = position.z + eye_rise;
  gl_Position = eye_to_clip * vec4(position, 1.0);
}
