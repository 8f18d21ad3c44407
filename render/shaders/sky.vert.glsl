#version 330 core

uniform vec3 right;    // scaled to half the picture's width at depth 1
uniform vec3 up;
uniform vec3 forward;

out vec3 direction;

void main() {
  // One triangle that covers the picture.
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  direction = forward + corner.x * right + corner.y * up;
  gl_Position = vec4(corner, 0.0, 1.0);
}
