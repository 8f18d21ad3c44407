#version 330 core
in vec2 east_north;
out vec2 normal;

void main() { normal = east_north; }
