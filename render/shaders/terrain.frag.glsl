#version 330 core

in vec3 from_eye;
in vec3 normal;
in float rise;

uniform vec3 to_sun;           // unit vector
uniform float relief;          // metres from the lowest ground to the highest: the range of the tint
uniform float haze_per_metre;

out vec4 color;

vec3 to_linear(vec3 srgb) { return pow(srgb, vec3(2.2)); }
vec3 to_srgb(vec3 linear) { return pow(clamp(linear, 0.0, 1.0), vec3(1.0 / 2.2)); }

const int kStops = 7;
const float kAt[kStops] = float[](0.0, 0.14, 0.30, 0.48, 0.66, 0.84, 1.0);
const vec3 kTint[kStops] = vec3[](
    vec3(0.36, 0.49, 0.38), vec3(0.52, 0.60, 0.42), vec3(0.73, 0.71, 0.51), vec3(0.74, 0.63, 0.47),
    vec3(0.62, 0.53, 0.46), vec3(0.75, 0.74, 0.74), vec3(0.97, 0.98, 0.99));

vec3 hypsometric(float t) {
  vec3 tint = to_linear(kTint[0]);
  for (int i = 1; i < kStops; ++i) {
    tint = mix(tint, to_linear(kTint[i]), smoothstep(kAt[i - 1], kAt[i], t));
  }
  return tint;
}

void main() {
  vec3 n = normalize(normal);
  // From below the surface shows its other side.
  if (dot(n, from_eye) > 0.0 && !gl_FrontFacing) n = -n;
  vec3 albedo = hypsometric(clamp(rise / relief, 0.0, 1.0));
  // Little grows on steep ground.
  albedo = mix(to_linear(vec3(0.52, 0.47, 0.43)), albedo, smoothstep(0.45, 0.85, abs(n.z)));

  const vec3 kSun = vec3(1.22, 1.14, 1.00);
  const vec3 kSky = vec3(0.25, 0.30, 0.38);
  const vec3 kGround = vec3(0.10, 0.09, 0.08);
  vec3 light = kSun * max(dot(n, to_sun), 0.0) + mix(kGround, kSky, 0.5 + 0.5 * n.z);
  vec3 lit = albedo * light;

  float haze = 1.0 - exp(-haze_per_metre * length(from_eye));
  color = vec4(to_srgb(mix(lit, to_linear(vec3(0.76, 0.83, 0.90)), haze)), 1.0);
}
