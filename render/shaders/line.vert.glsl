#version 330 core

layout(location = 0) in vec3 from_eye;   // metres east, north, up of the eye
layout(location = 1) in vec4 tone;

uniform mat4 eye_to_clip;

out vec4 line_color;

void main() {
  line_color = tone;
  gl_Position = eye_to_clip * vec4(from_eye, 1.0);
}
