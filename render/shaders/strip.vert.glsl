#version 330 core
flat out uint id;

void main() { id = uint(gl_VertexID); }
