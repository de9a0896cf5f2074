// The one descriptor set that all passes share, the value of "no surface", the unit of sums.
#ifndef FANLIGHT_SHADERS_BINDINGS_H
#define FANLIGHT_SHADERS_BINDINGS_H

#define FANLIGHT_BINDING_CAST_PARAMETERS 0
#define FANLIGHT_BINDING_LIGHT_PARAMETERS 1
#define FANLIGHT_BINDING_VOLUME 2     // 3D texture: column, row, frame by ascending angle
#define FANLIGHT_BINDING_FAN_TABLE 3  // 2D texture, z across and y down: in-plane depth mm, frame coordinate
#define FANLIGHT_BINDING_DEPTH 4      // float a pixel: pass 1's depth map, mm
#define FANLIGHT_BINDING_VOLUME_COLOUR 5  // packed RGBA8 a pixel: pass 1's composited volume
#define FANLIGHT_BINDING_ROW_SUMS 6       // uvec2 a pixel: sum of depths along the row, and their number
#define FANLIGHT_BINDING_SMOOTH_DEPTH 7   // float a pixel: the filtered depth map, mm
#define FANLIGHT_BINDING_LIT 8            // packed RGBA8 a pixel: pass 2's picture
#define FANLIGHT_BINDING_FINISHED 9       // packed RGBA8 a pixel: pass 3's picture
#define FANLIGHT_BINDINGS 10

// A depth is never negative, so this cannot be mistaken for one.
#define FANLIGHT_NO_SURFACE -1.0

// The unit in which the moving average sums depths.
#define FANLIGHT_SUM_UNITS_PER_MM 1024.0

#endif
