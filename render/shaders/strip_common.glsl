// Decodes one sub-strip of a tile of method `strip` (codec/strip_list.h); Dick et al. 2009, section 5. Before it come
// the version and the path's own way to put a word out, `put(word)`.

uniform usamplerBuffer headers;  // a texel a sub-strip
uniform usamplerBuffer entries;  // the densely packed entries, 32 bits a texel
uniform uint triangles;
uniform int levels;
uniform int height_bits;
uniform uint missing;            // the height of missing vertices, beyond all heights where there are none
uniform ivec4 borders;           // that skirts hang on: west, north, east, south; -1 for none
uniform bool skirts;             // what to put out: triangles, or the skirts below their border sides

const uint kFoot = 0x80000000u;
const ivec2 kDirections[8] = ivec2[8](ivec2(1, 0), ivec2(1, -1), ivec2(0, -1), ivec2(-1, -1), ivec2(-1, 0), ivec2(-1, 1),
                                      ivec2(0, 1), ivec2(1, 1));

void put(uint word);

uint entry(uint index) {
  uint bits = uint(height_bits) + 2u;
  uint at = index * bits;
  uint low = texelFetch(entries, int(at >> 5)).x >> (at & 31u);
  uint high = (at & 31u) == 0u ? 0u : texelFetch(entries, int(at >> 5) + 1).x << (32u - (at & 31u));
  return (low | high) & ((1u << bits) - 1u);
}

uint pack_vertex(ivec3 v) { return uint(v.x) | uint(v.y) << (levels + 1) | uint(v.z) << (2 * levels + 2); }

bool on_border(ivec3 a, ivec3 b) {
  return (a.x == b.x && (a.x == borders.x || a.x == borders.z)) || (a.y == b.y && (a.y == borders.y || a.y == borders.w));
}

void put_skirt(ivec3 a, ivec3 b) {
  if (!on_border(a, b)) return;
  uint p = pack_vertex(a);
  uint q = pack_vertex(b);
  put(q);
  put(p);
  put(p | kFoot);
  put(q);
  put(p | kFoot);
  put(q | kFoot);
}

void put_triangle(ivec3 a, ivec3 b, ivec3 c) {
  bool gone = uint(a.z) == missing || uint(b.z) == missing || uint(c.z) == missing;
  if (skirts) {
    if (gone) return;
    put_skirt(a, b);
    put_skirt(b, c);
    put_skirt(c, a);
  } else {
    put(gone ? 0u : pack_vertex(a));
    put(gone ? 0u : pack_vertex(b));
    put(gone ? 0u : pack_vertex(c));
  }
}

void decode(uint strip) {
  uint header = texelFetch(headers, int(strip)).x;
  int direction = int(header >> 20 & 7u);
  int size = int(header >> 23 & 15u);
  uint back = (header >> 27 & 7u) + 2u;
  bool back_is_v1 = (header >> 30 & 1u) != 0u;
  bool left = header >> 31 != 0u;
  uint first = strip * 16u + 2u;
  int near = int(entry(first - 1u) >> 2);
  int far = int(entry(first - min(back, first)) >> 2);
  ivec3 v1 = ivec3(int(header & 1023u), int(header >> 10 & 1023u), back_is_v1 ? far : near);
  ivec3 v2 = ivec3(v1.xy + kDirections[direction] * (1 << size), back_is_v1 ? near : far);
  bool right = left == ((entry(first) & 3u) == 1u);
  uint end = min(triangles, (strip + 1u) * 16u);
  for (uint i = strip * 16u; i < end; ++i) {
    uint e = entry(i + 2u);
    uint type = e & 3u;
    left = right == (type == 1u);
    right = left == (type == 2u);
    bool diagonal = (direction & 1) != 0;
    int turn = type == 0u ? 2 : 1;
    size += type == 1u && diagonal ? 1 : type == 2u && !diagonal ? -1 : 0;
    direction = (direction + (left ? turn : 8 - turn)) & 7;
    ivec2 way = kDirections[direction] * (1 << (size & 31));
    ivec3 v3 = ivec3(left ? v1.xy + way : v2.xy - way, int(e >> 2));
    put_triangle(v1, v2, v3);
    if (left) v2 = v3;
    else v1 = v3;
  }
}
