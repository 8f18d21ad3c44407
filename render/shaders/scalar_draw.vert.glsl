// Tiles of method scalar, dequantised by a matrix, or by a table of heights (Fowler et al., section 3.2).
// The place and height of a vertex tells scalar_word.glsl; where it is, render/scalar_placement.h.
ivec2 place();
int index_of_height();
bool is_foot();
bool is_uniform(ivec2 at);
int height(ivec2 at);

layout(location = 1) in vec2 normal_xy;

uniform mat4 index_to_eye;     // address steps and the quantiser's indices to metres east, north, up of the eye
uniform mat4 lattice_to_eye;   // samples and height steps from the lattice's origin to the same
uniform ivec4 corner_and_shift;  // the tile's corner on the lattice; an address step is 2^w samples
uniform ivec4 borders;         // that skirts hang on: west, north, east, south; -1 for none
uniform float tile_share;      // of a tile's side that a step is

void main() {
  ivec2 at = place();
  vec4 position = is_uniform(at)
      ? index_to_eye * vec4(at, index_of_height(), 1.0)
      : lattice_to_eye * vec4(corner_and_shift.xyz + ivec3(at << corner_and_shift.w, height(at)), 1.0);
  rise = position.z + eye_rise;
  if (is_foot()) {
    // As cache::SkirtSide.
    uint sides = (at.x == borders.x ? 1u : 0u) | (at.x == borders.z ? 2u : 0u) | (at.y == borders.y ? 4u : 0u) |
                 (at.y == borders.w ? 8u : 0u);
    position.xyz = foot_of(position.xyz, sides, lattice_to_eye[0].xy, lattice_to_eye[1].xy);
  }
  on_tile = tile_share * vec2(at);
  put_ground(position.xyz, normal_xy);
}
