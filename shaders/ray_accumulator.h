// SPDX-License-Identifier: Apache-2.0
// The result of pass 1 along one ray besides the surface: the composited colour, or the maximum, the minimum
// or the mean of its samples (renderer/ALGORITHM.md, pass 1). The includer has declared the texture
// `transfer` and the specialisation constant kKeep (cast.comp).
//
// Compositing is front to back, with colour c and opacity a of a sample: C += (1 - A) a c, A += (1 - A) a.
#ifndef FANLIGHT_SHADERS_RAY_ACCUMULATOR_H
#define FANLIGHT_SHADERS_RAY_ACCUMULATOR_H

// From this opacity on, samples behind change the picture by less than one of 255 levels.
const float kOpaque = 0.997;

struct RayAccumulator {
  vec3 colour;    // composited, premultiplied by opacity; or the normals of layers (glass_layers.h)
  float opacity;  // 0 to 1
  float extreme;  // maximum or minimum, 0 to 1; outside that range before the first sample
  float sum;      // of samples, and their number: the mean
  float count;
};

RayAccumulator new_ray_accumulator() {
  return RayAccumulator(vec3(0.0), 0.0, kKeep == FANLIGHT_KEEP_MINIMUM ? 2.0 : -1.0, 0.0, 0.0);
}

// Colour and opacity of one sample, 0 to 1.
vec4 transfer_at(float value) {
  return textureLod(transfer, (value * 255.0 + 0.5) / 256.0, 0.0);
}

// Adds one sample, 0 to 1, where it is `shown`: scanned and not cropped.
void accumulate(inout RayAccumulator ray, float value, bool shown) {
  if (kKeep == FANLIGHT_KEEP_COLOUR) {
    vec4 tissue = transfer_at(value);
    // Tested for each sample, not for each batch: the result must not depend on how a ray is cut into
    // batches.
    float share = shown && ray.opacity < kOpaque ? (1.0 - ray.opacity) * tissue.a : 0.0;
    ray.colour += share * tissue.rgb;
    ray.opacity += share;
  }
  if (kKeep == FANLIGHT_KEEP_MAXIMUM) ray.extreme = shown ? max(ray.extreme, value) : ray.extreme;
  if (kKeep == FANLIGHT_KEEP_MINIMUM) ray.extreme = shown ? min(ray.extreme, value) : ray.extreme;
  if (kKeep == FANLIGHT_KEEP_MEAN) {
    ray.sum += shown ? value : 0.0;
    ray.count += shown ? 1.0 : 0.0;
  }
}

// No further sample can change the colour.
bool complete(RayAccumulator ray) {
  bool composites = kKeep == FANLIGHT_KEEP_COLOUR || kKeep == FANLIGHT_KEEP_LAYERS;
  return kKeep == FANLIGHT_KEEP_NOTHING || (composites && ray.opacity >= kOpaque);
}

vec3 colour_of(RayAccumulator ray) {
  if (kKeep == FANLIGHT_KEEP_MAXIMUM) return vec3(max(ray.extreme, 0.0));
  if (kKeep == FANLIGHT_KEEP_MINIMUM) return vec3(ray.extreme > 1.0 ? 0.0 : ray.extreme);
  if (kKeep == FANLIGHT_KEEP_MEAN) return vec3(ray.sum / max(ray.count, 1.0));
  // For pass 2, not to be shown (layers_about() in glass.h): the root of the opacity, since a faint layer has
  // few levels of 255; and the mean normal to the right and upwards, of which 128 levels are 0.
  if (kKeep == FANLIGHT_KEEP_LAYERS) {
    vec2 normal = ray.colour.xy / max(ray.opacity, 1e-6);
    return vec3(sqrt(ray.opacity), (128.0 + 127.0 * normal) / 255.0);
  }
  return ray.colour;
}

#endif
