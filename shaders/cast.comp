// SPDX-License-Identifier: Apache-2.0
// Pass 1: casts one ray for each pixel, or for each 2 x 2 pixels, through the fan. A work group is a tile of
// 8 x 8 rays; a dispatch is a band of tiles, or a list of them (renderer/ALGORITHM.md, pass 1).
//
// Reads: the parameters; the volume and the angle table (fan_volume.h); segment_masks, one bit for each
//   segment of a tile's rays (empty_space.comp); tile_list, the tiles to cast again (dirty_tiles.comp); the
//   transfer function.
// Writes, height x width of the picture, top row first: depth and ray_depth (the same: mm below the view
//   plane, FANLIGHT_NO_SURFACE without a surface and outside the viewport), volume_colour (RGBA8, with the
//   certainty: certainty.h). For each tile: sample_ends.
//
// On llvmpipe neither `if` nor a loop saves work that no lane needs: both sides of a branch run under a mask,
// and a loop is entered whatever its condition. A loop that tests at its beginning also runs its body once
// more than needed, with no lanes. So loops test at their end, and what is needed once at most stands in an
// `if`.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "cast_parameters.h"
#include "certainty.h"
#include "near_tissue.h"

layout(local_size_x = 8, local_size_y = 8) in;

// Samples in the detector's window, even. A constant, so that the loops over the window unroll and the window
// stays in registers: an array that is indexed at run time lies in memory.
layout(constant_id = 0) const int kWindow = 8;
// FANLIGHT_KEEP_...; with FANLIGHT_KEEP_NOTHING the ray ends at the surface.
layout(constant_id = 1) const int kKeep = FANLIGHT_KEEP_NOTHING;
// FANLIGHT_FRAMES_...
layout(constant_id = 2) const int kFrames = FANLIGHT_FRAMES_PARALLEL;
// Where on its edge the surface lies: FANLIGHT_PLACE_...
layout(constant_id = 3) const int kPlace = FANLIGHT_PLACE_REFINED;
// A sample is the mean of 3 k points across the ray; that on the ray for 0.
layout(constant_id = 4) const int kAcross = 0;
// Rays skip the segments whose bits are not set.
layout(constant_id = 5) const bool kSkipping = true;
// Edges that are surfaces: +1 dark to bright, -1 bright to dark, 0 either.
layout(constant_id = 6) const int kSign = 0;
// FANLIGHT_CAST_...
layout(constant_id = 7) const int kTiles = FANLIGHT_CAST_ALL;

layout(binding = FANLIGHT_BINDING_TRANSFER) uniform sampler1D transfer;
layout(binding = FANLIGHT_BINDING_DEPTH, scalar) writeonly buffer DepthMap {
  float depth[];
};
layout(binding = FANLIGHT_BINDING_RAY_DEPTH, scalar) writeonly buffer RayDepths {
  float ray_depth[];
};
layout(binding = FANLIGHT_BINDING_SEGMENT_MASKS, scalar) readonly buffer SegmentMasks {
  uvec4 segment_masks[];
};
layout(binding = FANLIGHT_BINDING_SAMPLE_ENDS, scalar) buffer SampleEnds {
  uint sample_ends[];
};
layout(binding = FANLIGHT_BINDING_DIRTY_TILES, scalar) readonly buffer TileList {
  uint tile_list[];
};
layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) writeonly buffer Colours {
  uint volume_colour[];
};
// A copy of the parameters: read once, not in each iteration.
CastParameters rays;
#include "cut_mask.h"
#include "edge_detector.h"
#include "fan_volume.h"
#include "glass_layers.h"
#include "ray.h"
#include "ray_accumulator.h"
#include "sample_batch.h"
#include "segment_skip.h"
#include "surface_place.h"

// The depths of a ray between which anything was scanned: between the first and last column, the first and
// last frame, and above the last row. That body is convex, so it is one interval; last < first if it is
// empty.
vec2 scanned_interval(vec3 from, vec3 forward) {
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

// The samples of a ray that can change its result. Whole numbers: cropping a ray does not move its samples.
SampleRun samples_of_ray(Ray ray, vec2 shown) {
  vec2 part = scanned_interval(ray.from, ray.forward);
  // The detector's windows need samples beyond the shown part.
  float beyond_crop = 2.0 * float(kWindow) * ray.spacing;
  part = vec2(max(part.x, shown.x - beyond_crop), min(part.y, shown.y + beyond_crop));
  if (shown.x > shown.y) part = vec2(1.0, 0.0);
  float most = float(int(rays.steps));
  float first = clamp(ceil((part.x - rays.start) / ray.spacing), 0.0, most);
  float end = part.x > part.y ? 0.0 : clamp(floor((part.y - rays.start) / ray.spacing) + 1.0, 0.0, most);
  return SampleRun(first, end);
}

struct RayResult {
  float surface;    // its depth, mm, or FANLIGHT_NO_SURFACE
  float certainty;  // 0 to 1 where there is one
  vec3 colour;      // 0 to 1
  uint sample_end;  // the first sample that was not read
  uint taken;       // samples that were read, where they are counted
};

// Position of an edge that may be the surface: not cropped, and behind those that were `tried`. Else -1.
float candidate(float position, float tried, Ray ray, vec2 shown) {
  float depth_mm = rays.start + position * ray.spacing;
  return position > tried && depth_mm >= shown.x && depth_mm <= shown.y ? position : -1.0;
}

// The first of a batch's edges that may be the surface, or a layer behind it where there is one; else -1.
// `height`: of a layer.
float first_candidate(EdgesFound edges[kBatch], bool behind, float tried, Ray ray, vec2 shown,
                      inout float height) {
  float first = -1.0;
  [[unroll]] for (int slot = 0; slot < kBatch; ++slot) {
    float edge = candidate(behind ? edges[slot].layer : edges[slot].surface, tried, ray, shown);
    height = first < 0.0 && edge >= 0.0 ? edges[slot].layer_height : height;
    first = first >= 0.0 ? first : edge;
  }
  return first;
}

// A place outside what is shown moves to its border.
float shown_depth(float place, Ray ray, vec2 shown) {
  return clamp(rays.start + place * ray.spacing, shown.x, shown.y);
}

// Whether a sample counts that the accumulator gets.
bool is_kept(float t, Ray ray, vec2 shown, bool scanned) {
  bool kept = scanned && t >= shown.x && t <= shown.y;
  if (kKeep != FANLIGHT_KEEP_NOTHING && kKeep != FANLIGHT_KEEP_LAYERS) {
    if (kept && has_cuts()) kept = !is_cut(ray.from + t * ray.forward);
  }
  return kept;
}

// The depth of the surface whose edge lies at position `edge`, mm, and its certainty; FANLIGHT_NO_SURFACE
// without an edge, and where it is no surface or cut away.
float depth_of(float edge, Ray ray, SampleRun samples, vec2 shown, inout float certainty) {
  float place = edge;
  if (edge >= 0.0) {
    if (kPlace == FANLIGHT_PLACE_LEVEL) {
      place = placed_by_level(ray, samples, edge, certainty);
    } else {
      if (kPlace >= FANLIGHT_PLACE_TWO_SCALES) place = placed(ray, edge);
      // Only where it is asked for.
      if (rays.least_contrast > 0.0) certainty = certainty_at(ray, samples, edge);
      place = certainty < 0.0 ? kNotTissue : place;
    }
    if (has_cuts() && place > kNotTissue) {
      place = is_cut(ray.from + shown_depth(place, ray, shown) * ray.forward) ? kNotTissue : place;
    }
  }
  float depth_mm = shown_depth(place, ray, shown);
  return edge >= 0.0 && place > kNotTissue ? depth_mm : FANLIGHT_NO_SURFACE;
}

// Adds the layer at position `edge` unless it is cut away.
void add_layer_at(float edge, float height, float level, Ray ray, inout RayAccumulator accumulator) {
  if (edge >= 0.0) {
    float t = rays.start + edge * ray.spacing;
    bool kept = true;
    if (has_cuts()) kept = !is_cut(ray.from + t * ray.forward);
    if (kept) add_layer(accumulator, ray, t, height, level);
  }
}

// The share that is left of the certainty of a surface at `at`: the beam showed only the side that it came
// from. 1 up to 120 degrees between ray and beam, as in a view from the side of a fan, and 0 from 150 degrees
// on. Frames without a known apex have parallel beams.
float seen_by_beam(vec3 at, vec3 forward) {
  float from_axis = from_axis_of(at);
  float from_apex = max(from_axis - rays.motor_radius + rays.probe_radius, 1e-6);
  vec2 in_sweep = vec2(at.y + rays.motor_radius, at.z) / max(from_axis, 1e-6);
  vec3 beam = normalize(vec3(at.x / from_apex, in_sweep));
  const float kBehind = -0.866;
  float share = (dot(beam, normalize(forward)) - kBehind) / (-0.5 - kBehind);
  return clamp(share, rays.least_seen_by_beam, 1.0);
}

// Nothing before `start_mm` is shown.
RayResult cast_ray(Ray ray, float start_mm, uvec4 segment_mask) {
  vec2 shown = cropped(vec2(max(rays.start, start_mm), rays.end), ray.from, ray.forward);
  SampleRun samples = samples_of_ray(ray, shown);
  EdgeDetector detector;
  start(detector);
  RayAccumulator accumulator = new_ray_accumulator();
  float surface_mm = FANLIGHT_NO_SURFACE;
  float certainty = 1.0;
  EdgesFound edges[kBatch];  // that ended in the last batch
  [[unroll]] for (int slot = 0; slot < kBatch; ++slot) edges[slot] = EdgesFound(-1.0, -1.0, 0.0);
  float tried = -1.0;  // the last edge that is no surface, or no other layer
  float height = 0.0;  // of a layer
  float index = samples.first;
  uint taken = 0u;
  bool done = false;
  // One iteration ends at an edge, or with the ray.
  do {
    bool behind = surface_mm >= 0.0;
    bool seeks = !behind || kKeep == FANLIGHT_KEEP_LAYERS;
    float edge = seeks ? first_candidate(edges, behind, tried, ray, shown, height) : -1.0;
    bool stops = edge >= 0.0;
    // One iteration is a run of segments, so that the next run is not searched in every batch.
    bool searches = index < samples.end && !stops;
    do {
      if (!searches) continue;
      float run_end = kSkipping ? index : samples.end;
      if (kSkipping && !is_pending(detector)) {
        SampleRun run = next_run(segment_mask, index, samples.end);
        restart_where(detector, run.first > index);
        index = run.first;
        run_end = run.end;
      }
      // A run continues where an edge is pending: its peak may lie in the next segment.
      bool runs = index < samples.end && (index < run_end || is_pending(detector));
      do {
        if (!runs) continue;
        float batch[kBatch];
        samples_from(ray, index, batch);
        if (kTiles == FANLIGHT_CAST_ALL_COUNTED) taken += uint(kBatch);
        [[unroll]] for (int slot = 0; slot < kBatch; ++slot) {
          // The last batch may go beyond the ray's end.
          bool scanned = index < samples.end && batch[slot] >= 0.0;
          batch[slot] = max(batch[slot], 0.0);
          edges[slot] = advance(detector, slot, batch[slot], scanned, index);
          float t = rays.start + index * ray.spacing;
          accumulate(accumulator, batch[slot], is_kept(t, ray, shown, scanned));
          index += 1.0;
        }
        shift_window(detector, batch);
        edge = seeks ? first_candidate(edges, behind, tried, ray, shown, height) : -1.0;
        stops = edge >= 0.0 || (behind && complete(accumulator));
        runs = index < samples.end && !stops && (index < run_end || is_pending(detector));
      } while (runs);
      searches = index < samples.end && !stops;
    } while (searches);
    if (edge < 0.0 && seeks) {
      edge = candidate(behind ? last_layer(detector) : last_edge(detector), tried, ray, shown);
      height = detector.layer.peak;
    }
    if (kKeep == FANLIGHT_KEEP_LAYERS)
      add_layer_at(behind ? edge : -1.0, height, detector.level, ray, accumulator);
    tried = max(tried, edge);
    if (!behind) {
      surface_mm = depth_of(edge, ray, samples, shown, certainty);
      tried = surface_mm >= 0.0 ? tried + float(kOwnLayer) : tried;
    }
    done = edge < 0.0 || (surface_mm >= 0.0 && complete(accumulator));
  } while (!done);
  certainty *= seen_by_beam(ray.from + surface_mm * ray.forward, ray.forward);
  return RayResult(surface_mm, certainty, colour_of(accumulator), uint(whole(index)), taken);
}

// The tile of this work group. lavapipe gives each of two threads one half of the groups, and the dispatch
// takes as long as the slower half: each thread gets every other tile.
uint tile_of_group() {
  uint half_of_band = (gl_NumWorkGroups.x + 1u) / 2u;
  bool second_half = gl_WorkGroupID.x >= half_of_band;
  uint in_band = 2u * (gl_WorkGroupID.x - (second_half ? half_of_band : 0u)) + uint(second_half);
  return kTiles == FANLIGHT_CAST_LISTED ? tile_list[3u + in_band] : rays.first_tile + in_band;
}

// Eight invocations, the lanes of a processor's vector, cast a block of 4 x 2 rays: the nearer they are, the
// more of their samples lie in the same segments, and a lane that skips one waits for the others.
uvec2 place_in_tile() {
  uint lane = gl_LocalInvocationIndex & 7u;
  uint block = gl_LocalInvocationIndex >> 3u;
  return uvec2(4u * (block & 1u) + (lane & 3u), 2u * (block >> 1u) + (lane >> 2u));
}

// The first pixel of this invocation's ray. Tiles are numbered along the rows of tiles.
uvec2 first_pixel(uint tile) {
  uint tile_side = 8u * rays.pixel_stride;
  // In floats: integers are divided lane by lane. Half a tile protects the quotient from rounding.
  int tiles_across = int((rays.width + tile_side - 1u) / tile_side);
  int tile_row = int((float(int(tile)) + 0.5) / float(tiles_across));
  return tile_side * uvec2(int(tile) - tile_row * tiles_across, tile_row) +
         rays.pixel_stride * place_in_tile();
}

// A pixel before the viewport wraps to a number beyond its size.
bool in_viewport(uvec2 pixel) {
  uvec2 in_view = pixel - uvec2(rays.view_left, rays.view_top);
  return in_view.x < rays.view_width && in_view.y < rays.view_height;
}

// Writes the result to all pixels of the ray that lie in the picture.
void write_pixels(uvec2 first, RayResult result) {
  float alpha = result.surface >= 0.0 ? alpha_of(result.certainty) : 0.0;
  uint packed_colour = packUnorm4x8(vec4(result.colour, alpha));
  for (uint down = 0u; down < rays.pixel_stride; ++down) {
    for (uint across = 0u; across < rays.pixel_stride; ++across) {
      uvec2 pixel = first + uvec2(across, down);
      if (pixel.x >= rays.width || pixel.y >= rays.height) continue;
      bool shown = in_viewport(pixel);
      uint index = pixel.y * rays.width + pixel.x;
      float surface = shown ? result.surface : FANLIGHT_NO_SURFACE;
      depth[index] = surface;
      ray_depth[index] = surface;
      volume_colour[index] = shown ? packed_colour : packUnorm4x8(vec4(0.0, 0.0, 0.0, 1.0));
    }
  }
}

void main() {
  rays = parameters[FANLIGHT_PARAMETER_INDEX];
  uint tile = tile_of_group();
  uvec2 pixel = first_pixel(tile);
  if (pixel.x >= rays.width || pixel.y >= rays.height) return;
  // A ray for several pixels goes through the first of them in the viewport.
  uvec2 view_first = uvec2(rays.view_left, rays.view_top);
  uvec2 ray_pixel = rays.pixel_stride > 1u ? max(pixel, view_first) : pixel;
  bool has_ray = all(lessThan(ray_pixel, pixel + rays.pixel_stride)) && in_viewport(ray_pixel);

  RayResult result = RayResult(FANLIGHT_NO_SURFACE, 1.0, vec3(0.0), has_ray ? rays.steps : 0u, 0u);
  uvec4 segment_mask = kSkipping ? segment_masks[tile] : uvec4(~0u);
  if (has_ray && segment_mask != uvec4(0u)) {
    result = cast_ray(ray_of(vec2(ray_pixel)), start_of_ray(vec2(ray_pixel)), segment_mask);
  }
  if (kTiles == FANLIGHT_CAST_ALL_COUNTED) {
    atomicAdd(sample_ends[tile], result.taken);
  } else if (kTiles != FANLIGHT_CAST_ALL) {
    atomicMax(sample_ends[tile], result.sample_end);
  }
  write_pixels(pixel, result);
}
