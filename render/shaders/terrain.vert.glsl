layout(location = 0) in uvec4 packed_address;  // cache/drawable_tile.h, DrawVertex
layout(location = 1) in vec2 normal_xy;
// In place of these where morph is above 0 (cache/drawable_tile.h, MorphVertex).
layout(location = 2) in vec4 morph_address;    // x, y, height on the tile, height on its parent
layout(location = 3) in vec4 morph_normals_xy;
layout(location = 4) in uint morph_skirt_sides;

uniform mat4 address_to_eye;   // grid addresses to metres east, north, up of the eye
uniform float tile_share;      // of a tile's side that an address step is
uniform float morph;           // share of the way to the parent's surface

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
  if (skirt_sides != 0u) position = foot_of(position, skirt_sides, address_to_eye[0].xy, address_to_eye[1].xy);
  on_tile = tile_share * address.xy;
  put_ground(position, level);
}
