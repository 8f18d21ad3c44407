#version 330 core

in vec3 direction;             // from the eye

uniform vec3 view;             // unit vector of the view
uniform vec3 moved;            // metres from the picture's eye to the eye
uniform float radius;          // of the sphere round the picture's eye that the picture lies on
uniform vec3 picture_right;    // of the picture, so that its sides are at 1
uniform vec3 picture_up;
uniform vec3 picture_forward;  // unit vector
uniform float picture_near;    // depth = picture_near / what the picture's depth says
uniform float near;            // the same of the frame
uniform sampler2D colors;      // times how much of a texel is ground
uniform sampler2D depths;

out vec4 color;

// Of the nearest texel, or, on an outline where nothing was drawn there, of the nearest ground among those that the
// colour is mixed of.
float depth_at(vec2 where) {
  float stored = texture(depths, where).x;
  if (stored > 0.0) return stored;
  ivec2 last = textureSize(depths, 0) - 1;
  ivec2 first = ivec2(floor(where * vec2(last + 1) - 0.5));
  for (int i = 0; i < 4; ++i) {
    stored = max(stored, texelFetch(depths, clamp(first + ivec2(i & 1, i >> 1), ivec2(0), last), 0).x);
  }
  return stored;
}

void main() {
  vec3 ray = normalize(direction);
  float ahead = dot(moved, ray);
  vec3 from_picture = moved + ray * (sqrt(max(ahead * ahead - dot(moved, moved) + radius * radius, 0.0)) - ahead);
  float depth = dot(from_picture, picture_forward);
  vec2 place = vec2(dot(from_picture, picture_right), dot(from_picture, picture_up)) / depth;
  if (depth <= 0.0 || max(abs(place.x), abs(place.y)) > 1.0) discard;
  color = texture(colors, 0.5 + 0.5 * place);
  if (color.a == 0.0) discard;
  float stored = depth_at(0.5 + 0.5 * place);
  vec3 at = stored > 0.0 ? from_picture * (picture_near / (stored * depth)) : from_picture;
  // A little behind where it is, so that the ground itself comes before it.
  gl_FragDepth = clamp(0.9999 * near / max(dot(at - moved, view), near), 0.0, 1.0);
}
