#version 330 core

in vec3 direction;

out vec4 color;

void main() {
  float sine = normalize(direction).z;
  const vec3 kHorizon = vec3(0.84, 0.89, 0.93);
  const vec3 kZenith = vec3(0.36, 0.56, 0.80);
  const vec3 kBelow = vec3(0.60, 0.66, 0.72);
  vec3 sky = sine > 0.0 ? mix(kHorizon, kZenith, 1.0 - pow(1.0 - sine, 2.5)) : mix(kHorizon, kBelow, pow(-sine, 0.8));
  color = vec4(sky, 1.0);
}
