// For normal_sums.geom.glsl.
flat out ivec3 address;

void main() {
  ivec2 at = place();
  address = ivec3(at, height(at));
}
