// What the vertex shaders of all kinds of tiles share. Positions are metres east, north, up of the eye.

uniform mat4 eye_to_clip;
uniform float gap_slope;       // what a gap measures across the view, a metre of depth
uniform vec3 ahead;            // of the view, unit length
uniform float least_gain;      // render/screen_error.h
uniform float eye_rise;        // metres of the eye above the lowest ground

out vec3 from_eye;
out vec3 normal;
out float rise;                // metres above the lowest ground
out vec2 on_tile;              // place on the tile's square, 0 to 1 eastward and southward

float depth_of(vec3 position) { return max(dot(ahead, position), 0.5 * length(position)); }

// How far a vertical metre moves, in metres across the view.
float gain_of(vec3 position) {
  return max(length(cross(ahead, vec3(-position.y, position.x, 0.0))) / depth_of(position), least_gain);
}

// Where a skirt ends: down by what a gap can measure, and half a pixel outward, under the neighbour, so that rounding
// leaves no pinhole where the border is seen from above. `sides`: cache::SkirtSide.
vec3 foot_of(vec3 position, uint sides, vec2 eastward, vec2 southward) {
  float reach = gap_slope * depth_of(position);
  float across = float((sides >> 1) & 1u) - float(sides & 1u);
  float down = float((sides >> 3) & 1u) - float((sides >> 2) & 1u);
  vec2 outward = across * normalize(eastward) + down * normalize(southward);
  return position + reach * vec3(0.5 * outward, -1.0 / gain_of(position));
}

// Puts a vertex out; `level`: the horizontal part of its normal.
void put_ground(vec3 position, vec2 level) {
  from_eye = position;
  normal = vec3(level, sqrt(max(0.0, 1.0 - dot(level, level))));
  gl_Position = eye_to_clip * vec4(position, 1.0);
}
