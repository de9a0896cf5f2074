// Pass 2: normals from three neighbouring pixels of the filtered depth map, Blinn-Phong under a point light,
// and a shadow ray over the height map (design, section 4).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_LIGHT_PARAMETERS, scalar) uniform Parameters { LightParameters lighting; };
layout(binding = FANLIGHT_BINDING_VOLUME_COLOUR, scalar) readonly buffer Colours { uint volume_colour[]; };
layout(binding = FANLIGHT_BINDING_SMOOTH_DEPTH, scalar) readonly buffer Smooth { float smooth_depth[]; };
layout(binding = FANLIGHT_BINDING_LIT, scalar) writeonly buffer Lit { uint lit[]; };

// A shadow ray has to pass this much, in pixels, below a height before it is hidden by it: otherwise a slope
// throws shadows on itself.
const float kShadowBias = 1.5;

float depth_at(ivec2 pixel) {
  return smooth_depth[uint(pixel.y) * lighting.width + uint(pixel.x)];
}

// Slope of the depth along one axis from the pixel and its next neighbour; where that one has no surface,
// from the one before; where neither has, none.
float slope(ivec2 pixel, ivec2 axis, float here) {
  ivec2 last = ivec2(lighting.width, lighting.height) - 1;
  float next = depth_at(min(pixel + axis, last));
  float before = depth_at(max(pixel - axis, ivec2(0)));
  bool has_next = next >= 0.0 && all(lessThanEqual(pixel + axis, last));
  bool has_before = before >= 0.0 && all(greaterThanEqual(pixel - axis, ivec2(0)));
  return (has_next ? next - here : has_before ? here - before : 0.0) / lighting.pixel;
}

// The pixel's place in the view frame, with height (towards the viewer) as third axis: right-handed.
vec3 place(vec2 pixel, float depth) {
  vec2 centre = 0.5 * (vec2(lighting.width, lighting.height) - 1.0);
  return vec3((pixel.x - centre.x) * lighting.pixel, (centre.y - pixel.y) * lighting.pixel, -depth);
}

// Whether the height map stands between a place on it and the light. Walks a pixel a step and ends at the
// light, at the picture's border, or above everything.
bool shadowed(vec2 pixel, vec3 from, vec3 light) {
  vec2 across = vec2(light.x - from.x, from.y - light.y) / lighting.pixel;  // in pixels, rows downwards
  float pixels = max(abs(across.x), abs(across.y));
  if (lighting.shadow >= 1.0 || pixels < 1.0) return false;
  vec2 pixel_step = across / pixels;
  float height_step = (light.z - from.z) / pixels;
  float top = -lighting.shadow_top;
  vec2 last = vec2(lighting.width, lighting.height) - 1.0;

  vec2 at = pixel;
  float height = from.z + kShadowBias * lighting.pixel;
  bool hidden = false;
  for (float walked = 1.0; walked < pixels && !hidden; walked += 1.0) {
    at += pixel_step;
    height += height_step;
    if (height > top || any(lessThan(at, vec2(0.0))) || any(greaterThan(at, last))) break;
    float depth = depth_at(ivec2(at + 0.5));
    hidden = depth >= 0.0 && -depth > height;
  }
  return hidden;
}

vec3 shade(ivec2 pixel, float depth) {
  vec3 at = place(vec2(pixel), depth);
  vec3 light = vec3(lighting.light.xy, -lighting.light.z);
  // Height is -depth and rows run downwards: (-d height/d right, -d height/d up, 1).
  vec3 normal = normalize(vec3(slope(pixel, ivec2(1, 0), depth), -slope(pixel, ivec2(0, 1), depth), 1.0));
  vec3 toward = light - at;
  vec3 to_light = toward / max(length(toward), 1e-6);  // a light may lie on the surface
  vec3 halfway = normalize(to_light + vec3(0.0, 0.0, 1.0));  // parallel rays: the viewer is at infinity
  float facing = max(dot(normal, to_light), 0.0);
  float gleam = facing > 0.0 ? pow(max(dot(normal, halfway), 0.0), lighting.shininess) : 0.0;
  float direct = facing > 0.0 && shadowed(vec2(pixel), at, light) ? lighting.shadow : 1.0;
  // The paper scales the whole pixel by the shadow coefficient, ambient light included.
  vec3 matt = lighting.skin * (lighting.ambient + lighting.diffuse * facing);
  return direct * (matt + vec3(lighting.specular * gleam));
}

vec3 encoded(vec3 linear) {
  vec3 bounded = clamp(linear, 0.0, 1.0);
  vec3 curve = 1.055 * pow(bounded, vec3(1.0 / 2.4)) - 0.055;
  return mix(curve, 12.92 * bounded, lessThan(bounded, vec3(0.0031308)));
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  uint index = uint(pixel.y) * lighting.width + uint(pixel.x);
  float depth = smooth_depth[index];
  vec3 surface = depth >= 0.0 ? encoded(shade(pixel, depth)) : vec3(0.0);
  vec3 colour = lighting.show_volume != 0 ? unpackUnorm4x8(volume_colour[index]).rgb : surface;
  lit[index] = packUnorm4x8(vec4(colour, 1.0));
}
