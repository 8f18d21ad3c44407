// Tiles of method strip, drawn from their words as indices: the index is the vertex (Dick et al. 2009, section 6).

uniform mat4 address_to_eye;   // strip steps and height steps to metres east, north, up of the eye
uniform int xy_bits;           // of a word; the height has the rest, but the uppermost bit, which marks a skirt's foot
uniform float height_unit;     // height steps of a word's unit
uniform ivec4 borders;         // that skirts hang on: west, north, east, south; -1 for none
uniform float tile_share;      // of a tile's side that a step is

void main() {
  uint word = uint(gl_VertexID);
  uint mask = (1u << xy_bits) - 1u;
  ivec2 place = ivec2(word & mask, word >> xy_bits & mask);
  float height = height_unit * float((word & 0x7fffffffu) >> (2 * xy_bits));
  vec3 position = (address_to_eye * vec4(vec2(place), height, 1.0)).xyz;
  rise = position.z + eye_rise;
  if (word >> 31 != 0u) {
    // As cache::SkirtSide.
    uint sides = (place.x == borders.x ? 1u : 0u) | (place.x == borders.z ? 2u : 0u) |
                 (place.y == borders.y ? 4u : 0u) | (place.y == borders.w ? 8u : 0u);
    position = foot_of(position, sides, address_to_eye[0].xy, address_to_eye[1].xy);
  }
  on_tile = tile_share * vec2(place);
  put_ground(position, vec2(0.0));
}
