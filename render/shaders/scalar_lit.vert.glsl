// Gives a vertex its normal, out of the sums at its place: cache::DrawVertex's, in a second word.
uniform sampler2D sums;

flat out uvec2 lit;

void main() {
  vec3 sum = texelFetch(sums, place(), 0).xyz;
  ivec2 level = ivec2(round(32767.0 * sum.xy / max(length(sum), 1e-30)));
  lit = uvec2(word, uint(level.x & 0xffff) | uint(level.y & 0xffff) << 16);
}
