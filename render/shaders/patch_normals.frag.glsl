#version 330 core

// The normals at a tile's nodes, from the heights of its patch (cache/tile_relief.h).

uniform isampler2D heights;
uniform usampler2D surface;  // 0 where there is none
uniform int masked;          // whether that counts
uniform vec4 on_raster;      // the first column and row, the last ones
uniform float node_shift;
uniform vec4 slopes;         // a 2x2 matrix, column-major

out vec2 normal;             // east and north of the unit normal

bool is_there(ivec2 at) {
  vec2 place = vec2(at);
  if (any(lessThan(place, on_raster.xy)) || any(greaterThan(place, on_raster.zw))) return false;
  return masked == 0 || texelFetch(surface, at, 0).r != 0u;
}

int height(ivec2 at) { return texelFetch(heights, at, 0).r; }

// The rise a spacing, the mean over both sides where both are there.
bool rise(ivec2 at, ivec2 way, out float units) {
  bool before = is_there(at - way);
  bool after = is_there(at + way);
  units = 0.0;
  if (before && after) units = 0.5 * float(height(at + way) - height(at - way));
  else if (after) units = float(height(at + way) - height(at));
  else if (before) units = float(height(at) - height(at - way));
  return before || after;
}

// Both rises and a weight, or nothing.
vec3 rises(ivec2 at, float weight) {
  float across;
  float down;
  if (weight == 0.0 || !is_there(at)) return vec3(0.0);
  if (!rise(at, ivec2(1, 0), across) || !rise(at, ivec2(0, 1), down)) return vec3(0.0);
  return weight * vec3(across, down, 1.0);
}

void main() {
  // The node lies between these four samples.
  ivec2 corner = ivec2(gl_FragCoord.xy) + 1;
  vec3 sum = vec3(0.0);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) {
      float weight = (x == 0 ? node_shift : 1.0 - node_shift) * (y == 0 ? node_shift : 1.0 - node_shift);
      sum += rises(corner + ivec2(x, y), weight);
    }
  }
  // Beside holes: what the samples around have, so that nothing else is filtered in.
  if (sum.z == 0.0) {
    for (int y = -1; y < 3; ++y) {
      for (int x = -1; x < 3; ++x) sum += rises(corner + ivec2(x, y), 1.0);
    }
  }
  vec2 mean = sum.z > 0.0 ? sum.xy / sum.z : vec2(0.0);
  vec2 slope = mat2(slopes.xy, slopes.zw) * mean;
  normal = -slope / sqrt(1.0 + dot(slope, slope));
}
