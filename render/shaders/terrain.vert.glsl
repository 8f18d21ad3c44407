#version 330 core

layout(location = 0) in uvec4 packed_address;  // cache/drawable_tile.h, DrawVertex
layout(location = 1) in vec2 normal_xy;
// In place of these where morph is above 0 (cache/drawable_tile.h, MorphVertex).
layout(location = 2) in vec4 morph_address;    // x, y, height on the tile, height on its parent
layout(location = 3) in vec4 morph_normals_xy;
layout(location = 4) in uint morph_skirt_sides;

uniform mat4 address_to_eye;   // grid addresses to metres east, north, up of the eye
uniform mat4 eye_to_clip;
uniform float tile_share;      // of a tile's side that an address step is
uniform float morph;           // share of the way to the parent's surface
uniform float gap_slope;       // what a gap measures across the view, a metre of depth
uniform vec3 ahead;            // of the view, unit length
uniform float least_gain;      // render/screen_error.h
uniform float eye_rise;        // metres of the eye above the lowest ground

out vec3 from_eye;
out vec3 normal;
out float rise;                // metres above the lowest ground
out vec2 on_tile;              // place on the tile's square, 0 to 1 eastward and southward

void main() {
  uint high = packed_address.w;
  uint skirt_sides = high & 15u;
  vec3 address = vec3(packed_address.xyz | uvec3(high >> 4 & 7u, high >> 7 & 7u, high >> 10) << 16);
  vec2 level = normal_xy;
  if (morph > 0.0) {
    skirt_sides = morph_skirt_sides;
    address = vec3(morph_address.xy, mix(morph_address.z, morph_address.w, morph));
    level = mix(morph_normals_xy.xy, morph_normals_xy.zw, morph);
  }
  vec3 position = (address_to_eye * vec4(address, 1.0)).xyz;
  rise = position.z + eye_rise;
  if (skirt_sides != 0u) {
    // Down by what a gap can measure (render/screen_error.h), and half a pixel outward, under the neighbour, so that
    // rounding leaves no pinhole where the border is seen from above.
    float depth = max(dot(ahead, position), 0.5 * length(position));
    float gain = length(cross(ahead, vec3(-position.y, position.x, 0.0))) / depth;
    float reach = gap_slope * depth;
    float across = float((skirt_sides >> 1) & 1u) - float(skirt_sides & 1u);
    float down = float((skirt_sides >> 3) & 1u) - float((skirt_sides >> 2) & 1u);
    vec2 outward = across * normalize(address_to_eye[0].xy) + down * normalize(address_to_eye[1].xy);
    position += reach * vec3(0.5 * outward, -1.0 / max(gain, least_gain));
  }
  from_eye = position;
  on_tile = tile_share * address.xy;
  normal = vec3(level, sqrt(max(0.0, 1.0 - dot(level, level))));
  gl_Position = eye_to_clip * vec4(position, 1.0);
}
