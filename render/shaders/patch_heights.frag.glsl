#version 330 core

// A patch from its parent's and its residual, in integers as codec/wavelet_patch.cpp has them; Yusov & Turlapov 2008,
// section 3.4.

uniform isampler2D parent_heights;
uniform usampler2D numbers;  // the residual is low + step times these
uniform int low;
uniform int step;
uniform int has_parent;      // else the prediction is 0
uniform int east;            // of the parent's quadrant, samples of the patch
uniform int south;

out int height;

const int kMargin = 2;

// A sample lies a quarter of the parent's spacing off the nearer of the two that it is between.
int predicted(ivec2 at) {
  ivec2 whole = at + ivec2(east, south);
  ivec2 near = (whole + kMargin) >> 1;
  ivec2 far = near + 2 * (whole & 1) - 1;
  int sum = 9 * texelFetch(parent_heights, near, 0).r + 3 * texelFetch(parent_heights, ivec2(far.x, near.y), 0).r +
            3 * texelFetch(parent_heights, ivec2(near.x, far.y), 0).r + texelFetch(parent_heights, far, 0).r;
  // 16 times the height, in the parent's units of two.
  return (sum + 4) >> 3;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  height = (has_parent != 0 ? predicted(at) : 0) + low + step * int(texelFetch(numbers, at, 0).r);
}
