#version 330 core

in vec3 from_eye;
in vec3 normal;
in float rise;
in vec2 on_tile;               // 0 to 1 eastward and southward

uniform vec3 to_sun;           // unit vector
uniform float relief;          // metres from the lowest ground to the highest: the range of the tint
uniform vec4 tile_tint;        // sRGB colour of the tile in place of the ground's own, and how much of it
uniform float haze_begin;      // metres from the eye
uniform float haze_per_metre;
uniform sampler2D photo;              // light, times what of it a photo covers; and that share
uniform sampler2D normal_directions;  // east and north of unit normals
uniform sampler2D normal_lengths;     // of mean normals: the shorter the rougher the ground
uniform int normal_mapped;            // 0: the tile has no normal map
// Finer photos on squares in the tile, layer by layer; and for each of the smallest squares, row by row, the number of
// the layer (13 bits) and how often the tile was halved for that photo's square: 0 if there is none.
uniform sampler2DArray fine_photos;
uniform usampler2D fine_table;
uniform int fine_row;                 // the tile's in the table; -1: it has none
uniform int fine_depth;               // how often it is halved for the smallest squares

out vec4 color;

vec3 to_linear(vec3 srgb) { return pow(srgb, vec3(2.2)); }
vec3 to_srgb(vec3 linear) { return pow(clamp(linear, 0.0, 1.0), vec3(1.0 / 2.2)); }

const int kStops = 7;
const float kAt[kStops] = float[](0.0, 0.14, 0.30, 0.48, 0.66, 0.84, 1.0);
const vec3 kTint[kStops] = vec3[](
    vec3(0.30, 0.46, 0.33), vec3(0.44, 0.56, 0.36), vec3(0.68, 0.67, 0.44), vec3(0.72, 0.58, 0.41),
    vec3(0.58, 0.47, 0.40), vec3(0.74, 0.73, 0.73), vec3(0.98, 0.99, 1.00));

vec3 hypsometric(float t) {
  vec3 tint = to_linear(kTint[0]);
  for (int i = 1; i < kStops; ++i) {
    tint = mix(tint, to_linear(kTint[i]), smoothstep(kAt[i - 1], kAt[i], t));
  }
  return tint;
}

// The outer texels lie on the tile's sides, which they share with its neighbours.
vec2 place_in(sampler2D picture) {
  vec2 size = vec2(textureSize(picture, 0));
  return (on_tile * (size - 1.0) + 0.5) / size;
}

// Light and coverage.
vec4 photo_here() {
  // A single texel stands for no photo at all.
  vec4 seen = textureSize(photo, 0).x > 1 ? texture(photo, place_in(photo)) : vec4(0.0);
  if (fine_row < 0) return seen;
  // Neighbouring pixels may lie on other squares: their layers are filtered as if the tile had one picture.
  vec2 eastward = dFdx(on_tile);
  vec2 upward = dFdy(on_tile);
  int across = 1 << fine_depth;
  vec2 at = clamp(on_tile, 0.0, 1.0);
  ivec2 cell = min(ivec2(at * float(across)), across - 1);
  int entry = int(texelFetch(fine_table, ivec2(cell.y * across + cell.x, fine_row), 0).r);
  int halvings = entry >> 13;
  if (halvings == 0) return seen;
  float squares = float(1 << halvings);
  vec2 in_square = at * squares - vec2(cell >> (fine_depth - halvings));
  float size = float(textureSize(fine_photos, 0).x);
  float share = (size - 1.0) / size;
  vec3 place = vec3(in_square * share + 0.5 / size, float(entry & 8191));
  return textureGrad(fine_photos, place, eastward * squares * share, upward * squares * share);
}

void main() {
  vec3 n = normalize(normal);
  float smoothness = 1.0;
  if (normal_mapped != 0) {
    vec2 east_north = texture(normal_directions, place_in(normal_directions)).xy;
    n = normalize(vec3(east_north, sqrt(max(1.0 - dot(east_north, east_north), 1e-4))));
    smoothness = texture(normal_lengths, place_in(normal_lengths)).x;
  }
  // From below the surface shows its other side.
  if (dot(n, from_eye) > 0.0 && !gl_FrontFacing) n = -n;
  vec3 albedo = hypsometric(clamp(rise / relief, 0.0, 1.0));
  // Little grows on steep ground.
  albedo = mix(to_linear(vec3(0.52, 0.47, 0.43)), albedo, smoothstep(0.45, 0.85, abs(n.z)));
  albedo = mix(albedo, to_linear(tile_tint.rgb), tile_tint.a);

  vec4 seen = photo_here();
  albedo = seen.rgb + (1.0 - seen.a) * albedo;

  const vec3 kSun = vec3(1.45, 1.36, 1.20);
  const vec3 kSky = vec3(0.17, 0.21, 0.28);
  const vec3 kGround = vec3(0.08, 0.07, 0.06);
  vec3 light = kSun * max(smoothness * dot(n, to_sun), 0.0) + mix(kGround, kSky, 0.5 + 0.5 * n.z);
  vec3 lit = albedo * light;

  float haze = 1.0 - exp(-haze_per_metre * max(length(from_eye) - haze_begin, 0.0));
  color = vec4(to_srgb(mix(lit, to_linear(vec3(0.76, 0.83, 0.90)), haze)), 1.0);
}
