// The parameters of passes 2 and 3. Lengths in mm, in the view frame: right, up, depth.
#ifndef FANLIGHT_SHADERS_LIGHT_PARAMETERS_H
#define FANLIGHT_SHADERS_LIGHT_PARAMETERS_H
#include "vector_types.h"

FANLIGHT_SHADER_STRUCT(LightParameters) {
  uint width;  // of the picture
  uint height;
  float pixel;        // side of a picture's pixel in the body
  int filter_radius;  // the moving average spans 2 r + 1 pixels

  vec3 light;  // right of the picture's centre, above it, beyond the view plane
  float ambient;
  float diffuse;
  float specular;
  float shininess;
  float shadow;      // brightness left in a shadow; 1 casts none
  float shadow_top;  // no surface lies above this depth: a shadow ray may end there
  vec3 skin;         // colour of the surface under white light, linear, 0 to 1

  int show_volume;  // 1: the composited volume instead of the lit surface
  int mean;         // 1: 2 x 2 mean in pass 3
}
FANLIGHT_SHADER_STRUCT_END

#endif
