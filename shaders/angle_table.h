// From a place in the body to the frame coordinate, through the angle table. The includer has declared the parameters as
// `rays`.
#ifndef FANLIGHT_SHADERS_ANGLE_TABLE_H
#define FANLIGHT_SHADERS_ANGLE_TABLE_H

layout(binding = FANLIGHT_BINDING_ANGLE_TABLE) uniform samplerBuffer angle_table;

// The place in the table of an angle to the sweep's middle, by the tangent of half of it.
float table_place(float half_tangent) {
  return clamp(half_tangent * rays.angle_scale + rays.angle_offset, 0.0, rays.last_angle_entry);
}

// Two entries of the table, and where between them.
struct Angle {
  float below;
  float above;
  float share;
};

Angle angle_at(float across, float along, float length) {
  float place = table_place(across / max(length + along, 1e-6));
  float below = min(floor(place), rays.last_angle_entry - 1.0);
  return Angle(texelFetch(angle_table, int(below)).x, texelFetch(angle_table, int(below) + 1).x, place - below);
}

float frame_of(Angle angle) {
  // Between two entries: the nearest of eight times as many moved flat edges by tenths of a step.
  // A sample just inside the first or last frame could else reach for a frame that is not there.
  return clamp(mix(angle.below, angle.above, angle.share), 0.0, rays.last_frame);
}

// The coordinate among the frames of the half plane through the sweep axis in which the point (along, across) lies,
// `length` from the axis. The table is even in the tangent of the half angle, which takes no arc function.
float frame_at(float across, float along, float length) { return frame_of(angle_at(across, along, length)); }

#endif
