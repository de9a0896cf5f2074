// Pass 2: normals of the filtered depth map, Blinn-Phong, and a shadow ray over it (design, section 4); or whatever
// else the picture shows.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool kPerspective = false;
// The lamp has a radius.
layout(constant_id = 1) const bool kSoftShadows = true;

layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) readonly buffer Colours { uint volume_colour[]; };
layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) readonly buffer Smooth { float smooth_depth[]; };
layout(binding = FANLIGHT_BINDING_NEAREST, scalar) readonly buffer Nearest { uint nearest; };
layout(binding = FANLIGHT_BINDING_LIT, scalar) writeonly buffer Lit { uvec2 lit[]; };
#include "lit_picture.h"
#include "surface_map.h"

// A shadow ray has to pass this much, in pixels, below a height before it is hidden by it: otherwise a slope
// throws shadows on itself.
const float kShadowBias = 1.5;
// How far a shadow ray goes towards a directional light.
const float kShadowReach = 1000.0;

float depth_at(ivec2 pixel) {
  ivec2 first = ivec2(lighting.view_left, lighting.view_top);
  float there = smooth_depth[index_of(clamp(pixel, first, ivec2(lighting.view_right, lighting.view_bottom)))];
  return in_view(pixel) ? there : FANLIGHT_NO_SURFACE;
}

// What a length across the view measures at a depth, for each mm where pixels are measured.
float view_scale(float depth) {
  return kPerspective ? lighting.view_scale_at_0 + lighting.view_scale_per_mm * depth : 1.0;
}

// The pixel's place in the view frame, with height (towards the viewer) as third axis: right-handed.
vec3 place(vec2 pixel, float depth) {
  vec2 across = (pixel - lighting.centre) * lighting.pixel * view_scale(depth);
  return vec3(across.x, -across.y, -depth);
}

// The inverse: where a place shows.
vec2 pixel_of(vec3 at) {
  float scale = lighting.pixel * view_scale(-at.z);
  return lighting.centre + vec2(at.x, -at.y) / scale;
}

// From a pixel's place along one axis of the picture: between its neighbours, or to the one that has a surface; where
// neither has, level.
vec3 tangent(ivec2 pixel, ivec2 axis, float here) {
  float next = depth_at(pixel + axis);
  float before = depth_at(pixel - axis);
  bool central = lighting.central_normals != 0;
  bool has_next = central ? same_surface(next, here) : next >= 0.0;
  bool has_before = central ? same_surface(before, here) : before >= 0.0;
  vec3 at = place(vec2(pixel), here);
  vec3 from = has_before && (central || !has_next) ? place(vec2(pixel - axis), before) : at;
  vec3 to = has_next ? place(vec2(pixel + axis), next) : has_before ? at : place(vec2(pixel + axis), here);
  return to - from;
}

// The share of the lamp that is seen from a place on the height map: walks a pixel a step and ends at the light, at the
// viewport's border, or above everything.
float light_seen(vec3 from, float depth) {
  vec3 way = lighting.directional != 0 ? kShadowReach * lighting.light_direction : lighting.light - from;
  float lamp = lighting.directional != 0 ? lighting.lamp_distance : max(length(way), 1e-3);
  vec3 start = from + vec3(0.0, 0.0, kShadowBias * lighting.pixel * view_scale(depth));
  bool leaves = start.z + way.z > lighting.shadow_top;
  if (lighting.shadow >= 1.0 || (leaves && start.z >= lighting.shadow_top)) return 1.0;
  float part = leaves ? (lighting.shadow_top - start.z) / way.z : 1.0;
  // Where the ray is above all surfaces, and climbs faster than its blur widens, nothing hides the lamp any more.
  float climb = way.z - lighting.softness * length(way) / lamp;
  float to_nearest = -uintBitsToFloat(nearest) - start.z;
  if (climb > 0.0) part = min(part, max(to_nearest / climb, 0.0));
  vec3 end = start + part * way;

  vec2 start_pixel = pixel_of(start);
  vec2 across = pixel_of(end) - start_pixel;
  float pixels = max(abs(across.x), abs(across.y));
  float start_scale = view_scale(-start.z);
  float end_scale = view_scale(-end.z);
  float way_length = length(end - start);
  vec2 first = vec2(lighting.view_left, lighting.view_top);
  vec2 last = vec2(lighting.view_right, lighting.view_bottom);

  float share_of_pixel = 1.0 / pixels;
  float blur = lighting.softness * way_length / lamp;  // of the shadow's edge, at the way's end
  float seen = 1.0;
  for (float walked = 1.0; walked < pixels && seen > 0.0; walked += 1.0) {
    float share = walked * share_of_pixel;
    vec2 at = start_pixel + share * across;
    if (any(lessThan(at, first)) || any(greaterThan(at, last))) break;
    // Even steps in the picture are not even in the body, in perspective.
    float along = kPerspective ? share * start_scale / (share * start_scale + (1.0 - share) * end_scale) : share;
    float height = mix(start.z, end.z, along);
    float there = smooth_depth[index_of(ivec2(at + 0.5))];
    float clearance = there >= 0.0 ? height + there : 1e9;
    float visible = kSoftShadows ? clamp(0.5 + 0.5 * clearance / (blur * along), 0.0, 1.0) : (clearance < 0.0 ? 0.0 : 1.0);
    seen = min(seen, visible);
  }
  return seen;
}

vec3 shade(ivec2 pixel, float depth) {
  vec3 at = place(vec2(pixel), depth);
  // Rows run downwards.
  vec3 normal = normalize(cross(tangent(pixel, ivec2(1, 0), depth), -tangent(pixel, ivec2(0, 1), depth)));
  vec3 toward = lighting.light - at;
  vec3 to_point = toward / max(length(toward), 1e-6);  // a light may lie on the surface
  vec3 to_light = lighting.directional != 0 ? lighting.light_direction : to_point;
  // Parallel rays: the viewer is at infinity.
  vec3 to_eye = kPerspective ? normalize(vec3(0.0, 0.0, lighting.eye_height) - at) : vec3(0.0, 0.0, 1.0);
  vec3 halfway = normalize(to_light + to_eye);
  float facing = max(dot(normal, to_light), 0.0);
  float gleam = facing > 0.0 ? pow(max(dot(normal, halfway), 0.0), lighting.shininess) : 0.0;
  float direct = facing > 0.0 ? mix(lighting.shadow, 1.0, light_seen(at, depth)) : 1.0;
  // The paper scales the whole pixel by the shadow coefficient; but then a side turned away from the light, which has
  // nothing but ambient light, is brighter than a shadow beside it.
  vec3 ambient = lighting.ambient * lighting.material;
  return lighting.light_colour *
         (ambient + direct * (lighting.diffuse * facing * lighting.material + vec3(lighting.specular * gleam)));
}

vec3 encoded(vec3 linear) {
  vec3 bounded = clamp(linear, 0.0, 1.0);
  vec3 curve = 1.055 * pow(bounded, vec3(1.0 / 2.4)) - 0.055;
  return mix(curve, 12.92 * bounded, lessThan(bounded, vec3(0.0031308)));
}

vec3 colour_at(ivec2 pixel) { return unpackUnorm4x8(volume_colour[index_of(pixel)]).rgb; }

vec3 shown_at(ivec2 pixel) {
  if (!in_view(pixel)) {
    // Beside the surface: the planes where they are, or the volume's colours from the pixels that have rays.
    ivec2 from = pixel - ivec2(lighting.colours_from_left, 0);
    bool beyond = lighting.colours_from_left > 0 && (from.x < 0 || !in_view(from));
    return beyond ? vec3(0.0) : colour_at(from);
  }
  if (lighting.show == FANLIGHT_SHOW_COLOUR) return colour_at(pixel);
  float depth = smooth_depth[index_of(pixel)];
  if (depth < 0.0) return vec3(0.0);
  if (lighting.show == FANLIGHT_SHOW_DEPTH) {
    return vec3(clamp(1.0 - (depth - lighting.depth_white) * lighting.depth_scale, 0.0, 1.0));
  }
  return encoded(shade(pixel, depth));
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  vec3 colour = shown_at(pixel);
  lit[index_of(pixel)] = packed(colour);
}
