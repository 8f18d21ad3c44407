// A sub-strip an invocation. Words of triangles lie at their places, those of skirts as they come.
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Words { uint words[]; };
layout(std430, binding = 1) buffer Counter { uint skirt_words; };

uniform uint first_word;  // where the tile's begin, and end
uniform uint end_word;

uint next_word;
uint words_left;

void put(uint word) {
  // Skirts come six words at a time.
  if (skirts && words_left == 0u) {
    next_word = first_word + 3u * triangles + atomicAdd(skirt_words, 6u);
    words_left = 6u;
  }
  --words_left;
  if (next_word < end_word) words[next_word] = word;
  ++next_word;
}

void main() {
  uint strip = gl_GlobalInvocationID.x;
  if (strip * 16u >= triangles) return;
  next_word = first_word + strip * 48u;
  words_left = 0u;
  decode(strip);
}
