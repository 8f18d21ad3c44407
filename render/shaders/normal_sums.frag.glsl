#version 330 core
flat in vec3 weighted;
out vec4 added;

void main() { added = vec4(weighted, 0.0); }
