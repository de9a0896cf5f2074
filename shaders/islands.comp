// Pass 2: removes surfaces too small to be one: a pixel goes where less than a quarter of the window about it lies on
// its surface, as at the corner of a large one.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "light_parameters.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = FANLIGHT_BINDING_STEADY, scalar) readonly buffer Steady { float steady[]; };
layout(binding = FANLIGHT_BINDING_CLEANED, scalar) writeonly buffer Cleaned { float cleaned[]; };
layout(binding = FANLIGHT_BINDING_UNEVEN, scalar) readonly buffer Uneven { uint uneven[]; };
#include "surface_map.h"
#include "tiles.h"

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(lighting.width) || pixel.y >= int(lighting.height)) return;
  float here = steady[index_of(pixel)];
  ivec4 window = window_about(pixel, lighting.islands_radius);
  ivec2 size = window.zw - window.xy + 1;
  bool may_go = here >= 0.0 && uneven[tile_of(uvec2(pixel), lighting.width)] != 0u;
  int alike = may_go ? 0 : size.x * size.y;
  // Loops alone save work: where no pixel of a tile may go, nothing is read.
  for (int y = window.y; y <= (may_go ? window.w : -1); ++y) {
    for (int x = window.x; x <= window.z; ++x) {
      alike += same_surface(here, steady[index_of(ivec2(x, y))]) ? 1 : 0;
    }
  }
  cleaned[index_of(pixel)] = 4 * alike >= size.x * size.y ? here : FANLIGHT_NO_SURFACE;
}
