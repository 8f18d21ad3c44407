// A sub-strip a point; its words go to transform feedback.
layout(points) in;
layout(points, max_vertices = 96) out;
flat in uint id[];
out uint word;

void put(uint value) {
  word = value;
  EmitVertex();
}

void main() { decode(id[0]); }
