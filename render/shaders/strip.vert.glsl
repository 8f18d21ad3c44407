#version 330 core
flat out uint strip;

void main() { strip = uint(gl_VertexID); }
