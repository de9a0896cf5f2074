// SPDX-License-Identifier: Apache-2.0
// A surface as glass: what lies behind it is seen by its outlines (renderer/ALGORITHM.md, glass). The
// includer has included surface_light.h, and declared
//   vec3 pass1_layers(ivec2 pixel)   the colours of pass 1, unpacked: what colour_of() in ray_accumulator.h
//   gives
#ifndef FANLIGHT_SHADERS_GLASS_H
#define FANLIGHT_SHADERS_GLASS_H

// Outlines alone send less light than a surface: the picture keeps about its brightness.
const float kGlassGain = 1.8;

// The layers behind a pixel, composited front to back.
struct Layers {
  float opacity;  // 0 to 1
  vec2 normal;    // to the right and upwards, times the opacity
};

// The binomial mean over 3 x 3 pixels: an edge that a ray grazes is thinner than a pixel.
Layers layers_about(ivec2 pixel) {
  ivec2 first = ivec2(lighting.view_left, lighting.view_top);
  ivec2 last = ivec2(lighting.view_right, lighting.view_bottom);
  vec3 sum = vec3(0.0);
  for (int down = -1; down <= 1; ++down) {
    for (int right = -1; right <= 1; ++right) {
      vec3 kept = pass1_layers(clamp(pixel + ivec2(right, down), first, last));
      float weight = float((2 - abs(right)) * (2 - abs(down))) / 16.0;
      float opacity = kept.x * kept.x;
      sum += weight * opacity * vec3(1.0, (255.0 * kept.yz - 128.0) / 127.0);
    }
  }
  return Layers(sum.x, sum.yz);
}

// The opacity of the surface itself: 1 as skin; as glass, that of its outline.
float glass_opacity(float facing_viewer) {
  float away = 1.0 - facing_viewer;
  return mix(1.0, away * away * away, lighting.glass);
}

// The light of the layers, before the material's colour. Each is lit from half of its surroundings (half
// Lambert), so that the sum over layers needs no more than the sum of their normals.
vec3 layers_light(Layers layers, vec3 at) {
  vec3 light = lighting.ambient * layers.opacity * lighting.light_colour;
  for (int lamp = 0; lamp < lighting.lamps; ++lamp) {
    vec3 to_light = direction_to_light(at, lamp);
    float lit = 0.5 * (layers.opacity + dot(layers.normal, to_light.xy));
    light += lighting.diffuse * max(lit, 0.0) * lighting.lamp_colours[lamp];
  }
  return light;
}

#endif
