// Pass 1: one ray a pixel through the fan, sampled through the angle table (design, section 4).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "cast_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;  // a tile

// Samples that the detector compares, even. A constant, so that the loop over the window unrolls and the
// window lives in registers: indexed at run time it would live in memory.
layout(constant_id = 0) const int kWindow = 8;
// FANLIGHT_KEEP_...; with nothing to keep the ray ends at the surface.
layout(constant_id = 1) const int kKeep = FANLIGHT_KEEP_NOTHING;
// Frames are scan lines of a curved array.
layout(constant_id = 2) const bool kPolar = false;
// The surface lies at the steepest point of the edge, not where the threshold is crossed.
layout(constant_id = 3) const bool kRefined = true;
// A sample is the mean of (2 k + 1)^2 across the ray.
layout(constant_id = 4) const int kAcross = 0;
// Rays pass over the segments in which segments.comp found nothing to be seen.
layout(constant_id = 5) const bool kSkipping = true;

// Tiles are numbered along the rows of tiles; a work group takes the one of its own number after this.
layout(push_constant, scalar) uniform Band { uint first_tile; };
layout(binding = FANLIGHT_BINDING_CAST_PARAMETERS, scalar) uniform Parameters { CastParameters parameters; };
layout(binding = FANLIGHT_BINDING_TRANSFER) uniform sampler1D transfer;
layout(binding = FANLIGHT_BINDING_DEPTH, scalar) writeonly buffer DepthMap { float depth[]; };
layout(binding = FANLIGHT_BINDING_SEGMENTS, scalar) readonly buffer Segments { uvec4 segments[]; };
layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) writeonly buffer Colours { uint volume_colour[]; };
// A copy of the parameters: read once, not at every step of the loop.
CastParameters rays;
#include "fan_volume.h"
#include "ray.h"

// An opacity from which nothing behind changes the picture by a level of 255.
const float kOpaque = 0.997;
const int kHalf = kWindow / 2;
// Samples between two looks whether the ray is done or may pass over some: at most half a window.
const int kStretch = (kWindow + 3) / 4;

// The part of a ray in which anything was scanned: between the first and last column, the first and last frame, and
// within the last row: a convex body, so one stretch. Empty where its end lies before its start.
vec2 stretch_in_frames(vec3 from, vec3 forward) {
  vec2 part = vec2(max(rays.start, rays.eye), rays.end);
  part = cut(part, from.x - rays.left, forward.x);
  part = cut(part, rays.right_side - from.x, -forward.x);
  part = between_frames(part, from, forward);

  // |about_axis + t * forward| <= farthest
  vec2 about_axis = vec2(from.y + rays.motor_radius, from.z);
  float a = dot(forward.yz, forward.yz);
  float half_b = dot(about_axis, forward.yz);
  float c = dot(about_axis, about_axis) - rays.farthest * rays.farthest;
  float root = half_b * half_b - a * c;
  vec2 disc = a > 1e-12 ? (vec2(-half_b) + vec2(-1.0, 1.0) * sqrt(max(root, 0.0))) / a : part;
  bool misses = a > 1e-12 ? root < 0.0 : c > 0.0;
  return misses ? vec2(1.0, 0.0) : vec2(max(part.x, disc.x), min(part.y, disc.y));
}

// Where an edge peaks, in samples from the peak's own: the top of the parabola through it and its neighbours, where
// both are known (not negative).
float peak_offset(float before, float peak, float after) {
  float bend = before - 2.0 * peak + after;
  bool known = before >= 0.0 && after >= 0.0 && bend < 0.0;
  return known ? clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

vec4 transfer_at(float value) { return textureLod(transfer, (value * 255.0 + 0.5) / 256.0, 0.0); }

// The first sample from `from` on that lies in a segment that matters; beyond every ray where none does.
uint next_that_matters(uvec4 segments_of_tile, uint from) {
  uint segment = from >> rays.segment_shift;
  uint found = 1u << 24;
  [[unroll]] for (int part = FANLIGHT_MOST_SEGMENTS / 32 - 1; part >= 0; --part) {
    int behind = int(segment) - 32 * part;  // so many segments of this part are passed
    uint left = behind >= 32 ? 0u : segments_of_tile[part] & (~0u << uint(max(behind, 0)));
    found = left != 0u ? uint(32 * part + findLSB(left)) : found;
  }
  return max(from, found << rays.segment_shift);
}

void main() {
  rays = parameters;
  // lavapipe gives half of the groups to each of two threads, and the dispatch takes as long as the slower
  // half: each gets every other tile.
  uint half_of_band = (gl_NumWorkGroups.x + 1) / 2;
  bool later = gl_WorkGroupID.x >= half_of_band;
  uint tile = first_tile + 2 * (gl_WorkGroupID.x - (later ? half_of_band : 0)) + uint(later);
  uint tiles_across = (rays.width + 7u) / 8u;
  uvec2 pixel = 8u * uvec2(tile % tiles_across, tile / tiles_across) + gl_LocalInvocationID.xy;
  if (pixel.x >= rays.width || pixel.y >= rays.height) return;
  uvec2 in_view = pixel - uvec2(rays.view_left, rays.view_top);  // beyond the size where it lies before
  bool has_ray = in_view.x < rays.view_width && in_view.y < rays.view_height;

  Ray ray = ray_of(vec2(pixel));

  // Beyond what is shown, the detector's windows have samples to stand on.
  vec2 shown = cropped(vec2(rays.start, rays.end), ray.from, ray.forward);
  vec2 stretch = stretch_in_frames(ray.from, ray.forward);
  float beyond_crop = 2.0 * float(kWindow) * ray.spacing;
  stretch = vec2(max(stretch.x, shown.x - beyond_crop), min(stretch.y, shown.y + beyond_crop));
  if (!has_ray || shown.x > shown.y) stretch = vec2(1.0, 0.0);
  // Whole samples only, so that cutting a ray never moves one.
  float most = float(rays.steps);
  uint sample_index = uint(clamp(ceil((stretch.x - rays.start) / ray.spacing), 0.0, most));
  uint end = stretch.x > stretch.y ? 0u : uint(clamp(floor((stretch.y - rays.start) / ray.spacing) + 1.0, 0.0, most));

  float window[kWindow];  // the last samples, oldest first
  [[unroll]] for (int slot = 0; slot < kWindow; ++slot) window[slot] = 0.0;
  float difference = 0.0;    // sum of the newest half of the window - sum of the oldest half
  int scanned_in_a_row = 0;  // an edge of the fan is not an edge of tissue
  float last_edge = 0.0;
  const float level = rays.threshold * float(kHalf);

  // The edge under way: its peak so far, which sample that was, and the edge's height beside it (-1: not known).
  float peak = 0.0;
  float peak_index = 0.0;
  float before_peak = -1.0;
  float after_peak = -1.0;
  bool in_edge = false;

  float surface = FANLIGHT_NO_SURFACE;
  vec3 colour = vec3(0.0);
  float opacity = 0.0;
  float extreme = kKeep == FANLIGHT_KEEP_MINIMUM ? 2.0 : -1.0;
  float sum = 0.0;
  float count = 0.0;

  uvec4 segments_of_tile = kSkipping ? segments[tile] : uvec4(0u);
  bool done = false;
  while (sample_index < end && !done) {
    if (kSkipping) {
      // The detector begins anew before the next segment that matters, a window earlier.
      uint next = in_edge ? sample_index : next_that_matters(segments_of_tile, sample_index);
      uint from = max(next, uint(kWindow)) - uint(kWindow);
      bool passes_over = from > sample_index;
      sample_index = next >= end ? end : passes_over ? from : sample_index;
      [[unroll]] for (int slot = 0; slot < kWindow; ++slot) window[slot] = passes_over ? 0.0 : window[slot];
      difference = passes_over ? 0.0 : difference;
      scanned_in_a_row = passes_over ? 0 : scanned_in_a_row;
    }
    float fresh[kStretch];
    [[unroll]] for (int slot = 0; slot < kStretch; ++slot) {
      // The last stretch may go beyond the ray's end.
      bool taken = sample_index < end;
      float t = rays.start + float(sample_index) * ray.spacing;
      float value = sample_at(ray, t);
      scanned_in_a_row = taken && value >= 0.0 ? scanned_in_a_row + 1 : 0;
      bool scanned = scanned_in_a_row > 0;
      value = max(value, 0.0);
      fresh[slot] = value;

      // The sample that moves from the newest half to the oldest, and the one that leaves.
      difference += value - 2.0 * window[slot + kHalf] + window[slot];

      float edge = rays.edge_sign == 0 ? abs(difference) : float(rays.edge_sign) * difference;
      float index = float(sample_index);
      bool full = scanned_in_a_row >= kWindow;
      bool first = scanned_in_a_row == kWindow;  // there is no last edge then
      bool crossed = full && !in_edge && edge > level && (first || last_edge <= level);

      // In samples from the ray's start: the middle between the window's halves lies this far back.
      const float kBack = float(kHalf) - 0.5;
      float found = -1.0;
      if (kRefined) {
        after_peak = in_edge && full && index == peak_index + 1.0 ? edge : after_peak;
        bool ended = in_edge && (!full || edge <= max(level, 0.5 * peak));
        found = ended ? peak_index - kBack + peak_offset(before_peak, peak, after_peak) : -1.0;
        in_edge = in_edge && !ended;
        bool higher = crossed || (in_edge && edge > peak);
        peak = higher ? edge : peak;
        peak_index = higher ? index : peak_index;
        before_peak = higher ? (first ? -1.0 : last_edge) : before_peak;
        after_peak = higher ? -1.0 : after_peak;
        in_edge = in_edge || crossed;
      } else {
        // The crossing of the level lies between this step and the last.
        float rise = edge - last_edge;
        float beyond = first || rise <= 0.0 ? 0.0 : clamp((edge - level) / rise, 0.0, 1.0);
        found = crossed ? index - kBack - beyond : -1.0;
      }
      float place = rays.start + found * ray.spacing;
      bool is_surface = found >= 0.0 && surface < 0.0 && place >= shown.x && place <= shown.y;
      surface = is_surface ? place : surface;
      last_edge = edge;

      if (kKeep != FANLIGHT_KEEP_NOTHING) {
        bool kept = scanned && t >= shown.x && t <= shown.y;
        if (kKeep == FANLIGHT_KEEP_COLOUR) {
          vec4 look = transfer_at(value);
          // By the sample, not by the stretch: how a ray is cut into those shall not show.
          float share = kept && opacity < kOpaque ? (1.0 - opacity) * look.a : 0.0;
          colour += share * look.rgb;
          opacity += share;
        }
        if (kKeep == FANLIGHT_KEEP_MAXIMUM) extreme = kept ? max(extreme, value) : extreme;
        if (kKeep == FANLIGHT_KEEP_MINIMUM) extreme = kept ? min(extreme, value) : extreme;
        if (kKeep == FANLIGHT_KEEP_MEAN) {
          sum += kept ? value : 0.0;
          count += kept ? 1.0 : 0.0;
        }
      }
      ++sample_index;
    }
    [[unroll]] for (int slot = 0; slot < kWindow - kStretch; ++slot) window[slot] = window[slot + kStretch];
    [[unroll]] for (int slot = 0; slot < kStretch; ++slot) window[kWindow - kStretch + slot] = fresh[slot];
    bool settled = kKeep == FANLIGHT_KEEP_NOTHING || (kKeep == FANLIGHT_KEEP_COLOUR && opacity >= kOpaque);
    done = settled && surface >= 0.0;
  }
  if (kRefined && in_edge && surface < 0.0) {
    // The ray ended on the edge.
    float found = peak_index - (float(kHalf) - 0.5) + peak_offset(before_peak, peak, after_peak);
    float place = rays.start + found * ray.spacing;
    surface = place >= shown.x && place <= shown.y ? place : surface;
  }

  if (kKeep == FANLIGHT_KEEP_MAXIMUM) colour = vec3(max(extreme, 0.0));
  if (kKeep == FANLIGHT_KEEP_MINIMUM) colour = vec3(extreme > 1.0 ? 0.0 : extreme);
  if (kKeep == FANLIGHT_KEEP_MEAN) colour = vec3(sum / max(count, 1.0));
  uint index = pixel.y * rays.width + pixel.x;
  depth[index] = surface;
  volume_colour[index] = packUnorm4x8(vec4(colour, 1.0));
}
