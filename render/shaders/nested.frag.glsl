#version 330 core

in vec3 from_eye;
in float rise;

uniform vec3 to_sun;    // unit vector
uniform float relief;   // metres from the lowest ground to the highest

out vec4 color;

void main() {
  // The triangle's own normal: where a finer mesh lies on a coarser one both look the same.
  vec3 n = normalize(cross(dFdx(from_eye), dFdy(from_eye)));
  if (n.z < 0.0) n = -n;
  vec3 albedo = mix(vec3(0.20, 0.29, 0.14), vec3(0.80, 0.78, 0.74), clamp(rise / relief, 0.0, 1.0));
  vec3 lit = albedo * (vec3(1.45, 1.36, 1.20) * max(dot(n, to_sun), 0.0) + vec3(0.17, 0.21, 0.28));
  color = vec4(pow(clamp(lit, 0.0, 1.0), vec3(1.0 / 2.2)), 1.0);
}
