// Pass 1: one ray a pixel through the fan, sampled through the angle table (design, section 4).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "cast_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;  // a tile: 8 x 8 rays

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
// The edges that are surfaces: +1 dark to bright, -1 bright to dark, 0 either.
layout(constant_id = 6) const int kSign = 0;
// FANLIGHT_CAST_...
layout(constant_id = 7) const int kTiles = FANLIGHT_CAST_ALL;

// Tiles are numbered along the rows of tiles; a work group takes the one of its own number after this.
layout(binding = FANLIGHT_BINDING_TRANSFER) uniform sampler1D transfer;
layout(binding = FANLIGHT_BINDING_DEPTH, scalar) writeonly buffer DepthMap { float depth[]; };
layout(binding = FANLIGHT_BINDING_SEGMENTS, scalar) readonly buffer Segments { uvec4 segments[]; };
layout(binding = FANLIGHT_BINDING_REACHED, scalar) buffer Reached { uint reached[]; };
layout(binding = FANLIGHT_BINDING_TILE_LIST, scalar) readonly buffer TileList { uint tile_list[]; };
layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) writeonly buffer Colours { uint volume_colour[]; };
// A copy of the parameters: read once, not at every step of the loop.
CastParameters rays;
#include "fan_volume.h"
#include "ray.h"

// Before the window is full there is no last edge: lower than any, and so far that no rise from it has a middle.
const float kNoEdge = -1e9;
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

// The first sample from `from` on that lies in a segment whose bit is set; beyond every ray where none does.
int next_in(uvec4 segments_of_tile, int from) {
  int segment = from >> rays.segment_shift;
  int found = 1 << 16;
  [[unroll]] for (int part = FANLIGHT_MOST_SEGMENTS / 32 - 1; part >= 0; --part) {
    int behind = segment - 32 * part;  // so many segments of this part are passed
    uint left = behind >= 32 ? 0u : segments_of_tile[part] & (~0u << uint(max(behind, 0)));
    found = left != 0u ? 32 * part + findLSB(left) : found;
  }
  return max(from, found << rays.segment_shift);
}

// The echoes at the next samples, which do not depend on each other: a step of all of them comes before the next step of
// any, since a processor that takes them one by one waits for each. It took a fifth to a third off the pass on lavapipe.
void samples_from(Ray ray, float index, out float values[kStretch]) {
  if (kAcross > 0) {
    [[unroll]] for (int slot = 0; slot < kStretch; ++slot) {
      values[slot] = sample_at(ray, rays.start + (index + float(slot)) * ray.spacing);
    }
    return;
  }
  vec3 at[kStretch];
  float from_axis[kStretch];
  Angle angles[kStretch];
  Place places[kStretch];
  Voxels voxels[kStretch];
  [[unroll]] for (int slot = 0; slot < kStretch; ++slot) {
    at[slot] = ray.from + (rays.start + (index + float(slot)) * ray.spacing) * ray.forward;
    from_axis[slot] = from_axis_of(at[slot]);
  }
  [[unroll]] for (int slot = 0; slot < kStretch; ++slot) {
    angles[slot] = angle_at(at[slot].z, at[slot].y + rays.motor_radius, from_axis[slot]);
  }
  [[unroll]] for (int slot = 0; slot < kStretch; ++slot) {
    places[slot] = place_in_frame(at[slot], from_axis[slot]);
    places[slot].voxel.z = frame_of(angles[slot]);
  }
  [[unroll]] for (int slot = 0; slot < kStretch; ++slot) voxels[slot] = voxels_at(places[slot].voxel);
  [[unroll]] for (int slot = 0; slot < kStretch; ++slot) {
    float value = mixed(voxels[slot]);
    values[slot] = exact(places[slot].inside >= 0.0 ? value : -1.0);
  }
}

// What a ray shows.
struct Found {
  float surface;  // its depth
  vec3 colour;
  uint reached;  // the first sample that it did not look at
};

// The edge under way: its peak so far, which sample that was, and the edge's height beside it (negative: not known).
struct Edge {
  bool under_way;
  float peak;
  float index;
  float before;
  float after;
};

// The middle between the halves of the window whose newest sample this is, in samples from the ray's start.
float middle_of(float newest) { return newest - (float(kHalf) - 0.5); }

float place_of(Edge edge) { return middle_of(edge.index) + peak_offset(edge.before, edge.peak, edge.after); }

Found found_along(Ray ray, uvec4 segments_of_tile) {
  // Beyond what is shown, the detector's windows have samples to stand on.
  vec2 shown = cropped(vec2(rays.start, rays.end), ray.from, ray.forward);
  vec2 stretch = stretch_in_frames(ray.from, ray.forward);
  float beyond_crop = 2.0 * float(kWindow) * ray.spacing;
  stretch = vec2(max(stretch.x, shown.x - beyond_crop), min(stretch.y, shown.y + beyond_crop));
  if (shown.x > shown.y) stretch = vec2(1.0, 0.0);
  // Whole samples only, so that cutting a ray never moves one. They are counted in floats, which a processor need not
  // convert.
  float most = float(int(rays.steps));
  float index = clamp(ceil((stretch.x - rays.start) / ray.spacing), 0.0, most);
  float end = stretch.x > stretch.y ? 0.0 : clamp(floor((stretch.y - rays.start) / ray.spacing) + 1.0, 0.0, most);

  float window[kWindow];  // the last samples, oldest first
  [[unroll]] for (int slot = 0; slot < kWindow; ++slot) window[slot] = 0.0;
  float difference = 0.0;  // sum of the newest half of the window - sum of the oldest half
  int in_a_row = 0;        // samples that were scanned: an edge of the fan is not an edge of tissue
  float last_edge = kNoEdge;
  const float level = rays.threshold * float(kHalf);
  Edge edge = Edge(false, 0.0, 0.0, -1.0, -1.0);

  float surface = FANLIGHT_NO_SURFACE;
  vec3 colour = vec3(0.0);
  float opacity = 0.0;
  float extreme = kKeep == FANLIGHT_KEEP_MINIMUM ? 2.0 : -1.0;
  float sum = 0.0;
  float count = 0.0;

  bool done = false;
  // A turn is a run of segments that matter, so that the next one is not looked for at every stretch.
  while (index < end && !done) {
    float run_end = end;
    if (kSkipping) {
      int next = next_in(segments_of_tile, int(index));
      run_end = min(end, float(next_in(~segments_of_tile, next)));
      // The detector begins anew before the next segment that matters, a window earlier.
      float from = next >= int(end) ? end : float(next - kWindow);
      bool passes_over = from > index;
      index = max(from, index);
      [[unroll]] for (int slot = 0; slot < kWindow; ++slot) window[slot] = passes_over ? 0.0 : window[slot];
      difference = passes_over ? 0.0 : difference;
      in_a_row = passes_over ? 0 : in_a_row;
      last_edge = passes_over ? kNoEdge : last_edge;
    }
    while (index < end && !done && (index < run_end || edge.under_way)) {
      float fresh[kStretch];
      samples_from(ray, index, fresh);
      [[unroll]] for (int slot = 0; slot < kStretch; ++slot) {
        // The last stretch may go beyond the ray's end.
        bool taken = index < end;
        float t = rays.start + index * ray.spacing;
        float value = fresh[slot];
        bool scanned = taken && value >= 0.0;
        in_a_row = scanned ? in_a_row + 1 : 0;
        value = max(value, 0.0);
        fresh[slot] = value;

        // The sample that moves from the newest half to the oldest, and the one that leaves.
        difference += value - 2.0 * window[slot + kHalf] + window[slot];

        float height = kSign == 0 ? abs(difference) : float(kSign) * difference;
        bool full = in_a_row >= kWindow;
        bool crossed = full && height > level && last_edge <= level;

        // In samples from the ray's start.
        float found = -1.0;
        if (kRefined) {
          edge.after = index == edge.index + 1.0 && full ? height : edge.after;
          bool ended = edge.under_way && (!full || height <= max(level, 0.5 * edge.peak));
          found = ended ? place_of(edge) : -1.0;
          crossed = crossed && !edge.under_way;
          edge.under_way = edge.under_way && !ended;
          bool higher = crossed || (edge.under_way && height > edge.peak);
          edge.peak = higher ? height : edge.peak;
          edge.index = higher ? index : edge.index;
          edge.before = higher ? last_edge : edge.before;
          edge.after = higher ? -1.0 : edge.after;
          edge.under_way = edge.under_way || crossed;
        } else {
          // The crossing of the level lies between this step and the last.
          float beyond = min((height - level) / (height - last_edge), 1.0);
          found = crossed ? middle_of(index) - beyond : -1.0;
        }
        float place = rays.start + found * ray.spacing;
        bool is_surface = found >= 0.0 && surface < 0.0 && place >= shown.x && place <= shown.y;
        surface = is_surface ? place : surface;
        last_edge = full ? height : kNoEdge;

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
        index += 1.0;
      }
      [[unroll]] for (int slot = 0; slot < kWindow - kStretch; ++slot) window[slot] = window[slot + kStretch];
      [[unroll]] for (int slot = 0; slot < kStretch; ++slot) window[kWindow - kStretch + slot] = fresh[slot];
      bool settled = kKeep == FANLIGHT_KEEP_NOTHING || (kKeep == FANLIGHT_KEEP_COLOUR && opacity >= kOpaque);
      done = settled && surface >= 0.0;
    }
  }
  if (kRefined && edge.under_way && surface < 0.0) {
    // The ray ended on the edge.
    float place = rays.start + place_of(edge) * ray.spacing;
    surface = place >= shown.x && place <= shown.y ? place : surface;
  }

  if (kKeep == FANLIGHT_KEEP_MAXIMUM) colour = vec3(max(extreme, 0.0));
  if (kKeep == FANLIGHT_KEEP_MINIMUM) colour = vec3(extreme > 1.0 ? 0.0 : extreme);
  if (kKeep == FANLIGHT_KEEP_MEAN) colour = vec3(sum / max(count, 1.0));
  return Found(surface, colour, uint(int(index)));
}

void main() {
  rays = parameters[FANLIGHT_THE_ONLY];
  // lavapipe gives half of the groups to each of two threads, and the dispatch takes as long as the slower half: each gets
  // every other tile.
  uint half_of_band = (gl_NumWorkGroups.x + 1u) / 2u;
  bool later = gl_WorkGroupID.x >= half_of_band;
  uint in_band = 2u * (gl_WorkGroupID.x - (later ? half_of_band : 0u)) + uint(later);
  uint tile = kTiles == FANLIGHT_CAST_LISTED ? tile_list[3u + in_band] : rays.first_tile + in_band;
  uint tile_side = 8u * rays.pixel_stride;
  // In floats: integers are divided lane by lane. Half a tile keeps the quotient clear of rounding.
  int tiles_across = int((rays.width + tile_side - 1u) / tile_side);
  int tile_row = int((float(int(tile)) + 0.5) / float(tiles_across));
  uvec2 pixel = tile_side * uvec2(int(tile) - tile_row * tiles_across, tile_row) +
                rays.pixel_stride * gl_LocalInvocationID.xy;
  if (pixel.x >= rays.width || pixel.y >= rays.height) return;
  // Of several pixels for one ray, the first that lies in the viewport.
  uvec2 view_first = uvec2(rays.view_left, rays.view_top);
  uvec2 seen_pixel = rays.pixel_stride > 1u ? max(pixel, view_first) : pixel;
  uvec2 in_view = seen_pixel - view_first;  // beyond the size where it lies before
  bool has_ray = all(lessThan(seen_pixel, pixel + rays.pixel_stride)) && in_view.x < rays.view_width &&
                 in_view.y < rays.view_height;

  Found found = Found(FANLIGHT_NO_SURFACE, vec3(0.0), has_ray ? rays.steps : 0u);
  uvec4 segments_of_tile = kSkipping ? segments[tile] : uvec4(~0u);
  // A loop of one turn at most, since lavapipe walks through the inside of every `if`: where there is nothing to find in
  // the tile, the rays need not even be set up.
  for (bool due = has_ray && segments_of_tile != uvec4(0u); due; due = false) {
    found = found_along(ray_of(vec2(seen_pixel)), segments_of_tile);
  }
  if (kTiles != FANLIGHT_CAST_ALL) atomicMax(reached[tile], found.reached);
  uint packed_colour = packUnorm4x8(vec4(found.colour, 1.0));
  for (uint down = 0u; down < rays.pixel_stride; ++down) {
    for (uint across = 0u; across < rays.pixel_stride; ++across) {
      uvec2 shown_pixel = pixel + uvec2(across, down);
      if (shown_pixel.x >= rays.width || shown_pixel.y >= rays.height) continue;
      uvec2 place = shown_pixel - view_first;
      bool in_viewport = place.x < rays.view_width && place.y < rays.view_height;
      uint index = shown_pixel.y * rays.width + shown_pixel.x;
      depth[index] = in_viewport ? found.surface : FANLIGHT_NO_SURFACE;
      volume_colour[index] = in_viewport ? packed_colour : packUnorm4x8(vec4(0.0, 0.0, 0.0, 1.0));
    }
  }
}
