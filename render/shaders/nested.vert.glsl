// Tiles of method nested (Schneider and Westermann 2006). A triangle between two tiles has vertices of both, so all
// that belongs to a tile comes twice, and each vertex says whose it is.
layout(location = 0) in uvec2 packed_address;     // cache/nested_shape.h, NestedVertex
layout(location = 1) in vec4 coarse_rises;        // of the meshes of levels 0 to 3 at this vertex
layout(location = 2) in vec4 fine_rises;          // 4 to 7
layout(location = 3) in vec2 normal_xy;           // on level 8
layout(location = 4) in vec4 coarse_normals_xy;   // on levels 7 and 6
layout(location = 5) in uvec2 whose;              // 1 for the second tile's; the sides whose skirt it is the foot of

uniform mat4 address_to_eye[2];   // grid addresses to metres east, north, up of the eye
uniform vec4 coarse_units[2];     // height steps of a unit of the rises
uniform vec4 fine_units[2];
uniform vec4 detail[2];           // least and greatest level drawn; bounds of the tile that a metre of depth allows
uniform float tile_share;         // of the first tile's side that an address step of it is
uniform vec3 second_to_first;     // addresses: the scale, then what is added

// Linear in the error that is allowed: that of level i is 2^(8 - i) bounds (render/nested_lod.h).
float level_for(float bounds) {
  float coarser = max(log2(bounds), 0.0);
  return 9.0 - floor(coarser) - max(bounds, 1.0) * exp2(-floor(coarser));
}

void main() {
  uint tile = whose.x;
  vec3 address = vec3((packed_address.x & 0xffffu) | (packed_address.y >> 22 & 7u) << 16,
                      packed_address.x >> 16 | (packed_address.y >> 25 & 7u) << 16, packed_address.y & 0x3fffffu);
  vec3 finest = (address_to_eye[tile] * vec4(address, 1.0)).xyz;
  vec3 range = detail[tile].xyz;
  float level = clamp(level_for(range.z * depth_of(finest) / gain_of(finest)), range.x, range.y);
  // Forward differences of clamped ramps: the weights of the levels' heights.
  vec4 coarse = clamp(level - vec4(0.0, 1.0, 2.0, 3.0), 0.0, 1.0);
  vec4 fine = clamp(level - vec4(4.0, 5.0, 6.0, 7.0), 0.0, 1.0);
  vec4 coarse_weights = vec4(1.0, coarse.xyz) - coarse;
  vec4 fine_weights = vec4(coarse.w, fine.xyz) - fine;
  address.z += dot(coarse_weights, coarse_rises * coarse_units[tile]) + dot(fine_weights, fine_rises * fine_units[tile]);
  vec3 position = (address_to_eye[tile] * vec4(address, 1.0)).xyz;
  rise = position.z + eye_rise;
  if (whose.y != 0u) position = foot_of(position, whose.y, address_to_eye[tile][0].xy, address_to_eye[tile][1].xy);
  vec2 place = tile == 0u ? address.xy : address.xy * second_to_first.x + second_to_first.yz;
  on_tile = tile_share * place;
  put_ground(position, mix(mix(coarse_normals_xy.zw, coarse_normals_xy.xy, fine.z), normal_xy, fine.w));
}
