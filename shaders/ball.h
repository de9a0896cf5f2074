// A tile's rays bounded together: the samples of a segment lie in a ball. The includer has declared the parameters as `rays`
// and included angle_table.h.
#ifndef FANLIGHT_SHADERS_BALL_H
#define FANLIGHT_SHADERS_BALL_H

// A tile of 8 x 8 pixels: from its middle to its outermost pixels.
const float kTileReach = 3.5;
// So much wider is a ball taken than it is, for rounding, and for the curve of what lies between a tile's corners.
const float kSlackShare = 1.02;
const float kSlackMm = 0.01;
// The samples of one ray lie at first + index * step, in mm.
struct Line {
  vec3 first;
  vec3 step;
};

Line line_of(vec2 pixel) {
  vec3 from = rays.origin + pixel.x * rays.right_step + pixel.y * rays.down_step;
  vec3 forward = rays.forward + pixel.x * rays.right_turn + pixel.y * rays.down_turn;
  return Line(from + rays.start * forward, rays.step * normalize(forward));
}

// The radius of the ball about the middle of a segment that holds the segment's samples on the rays of the corners. It is
// convex along the rays, so a line between its values at two segments bounds it between them.
float reach_about(vec2 middle, float index, float half_length) {
  Line through = line_of(middle);
  vec3 centre = through.first + index * through.step;
  float reach_squared = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    vec2 side = vec2((corner & 1) != 0 ? kTileReach : -kTileReach, (corner & 2) != 0 ? kTileReach : -kTileReach);
    Line line = line_of(middle + side);
    vec3 away = line.first + (index + ((corner & 4) != 0 ? half_length : -half_length)) * line.step - centre;
    reach_squared = max(reach_squared, dot(away, away));
  }
  return sqrt(reach_squared);
}

// First and last of the frames that samples in the ball mix; last < first for none.
ivec2 frames_about(vec3 centre, float reach) {
  float along = centre.y + rays.motor_radius;
  float from_axis = sqrt(along * along + centre.z * centre.z);
  float sine = reach / max(from_axis, 1e-6);
  float widened = sine / (1.0 + sqrt(max(1.0 - sine * sine, 0.0)));  // tangent of half the angle that the ball spans
  float middle = centre.z / max(from_axis + along, 1e-6);
  // tan(a - b) and tan(a + b)
  float below = 1.0 + middle * widened;
  float above = 1.0 - middle * widened;
  bool about_axis = sine >= 1.0;
  float first = about_axis || below <= 0.0 ? -1e6 : (middle - widened) / below;
  float last = about_axis || above <= 0.0 ? 1e6 : (middle + widened) / above;
  // An entry more on either side, for rounding.
  float lowest = texelFetch(angle_table, max(int(table_place(first)) - 1, 0)).x;
  float highest = texelFetch(angle_table, min(int(table_place(last)) + 2, int(rays.last_angle_entry))).x;
  bool beside = highest < 0.0 || lowest > rays.last_frame;
  ivec2 frames = ivec2(floor(clamp(vec2(lowest, highest), 0.0, rays.last_frame)));
  return beside ? ivec2(0, -1) : ivec2(frames.x, min(frames.y + 1, int(rays.last_frame)));
}

#endif
