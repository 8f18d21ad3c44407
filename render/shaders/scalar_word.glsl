// Vertices of a tile of method `scalar` (cache/quantized_shape.h): place and index of the height.
layout(location = 0) in uint word;

uniform ivec4 bits_and_ends;       // bits of x and of y; the tile's width and height
uniform ivec4 quantizer;           // heights of index 0 on the sides and inside, step inside, 1 if a table is in its place
uniform usamplerBuffer level_table;

ivec2 place() {
  return ivec2(word & ((1u << bits_and_ends.x) - 1u), word >> bits_and_ends.x & ((1u << bits_and_ends.y) - 1u));
}

int index_of_height() { return int((word & 0x7fffffffu) >> (bits_and_ends.x + bits_and_ends.y)); }

bool is_foot() { return word >> 31 != 0u; }

bool on_side(ivec2 at) { return at.x == 0 || at.y == 0 || at.x == bits_and_ends.z || at.y == bits_and_ends.w; }

// Whether the height is an affine function of the index that all vertices inside have in common.
bool is_uniform(ivec2 at) { return quantizer.w == 0 && !on_side(at); }

// In height steps.
int height(ivec2 at) {
  int index = index_of_height();
  if (on_side(at)) return quantizer.x + index;
  return quantizer.w != 0 ? int(texelFetch(level_table, index).x) : quantizer.y + quantizer.z * index;
}
