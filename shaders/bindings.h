// The one descriptor set that all passes share, the value of "no surface", and what else both languages count.
#ifndef FANLIGHT_SHADERS_BINDINGS_H
#define FANLIGHT_SHADERS_BINDINGS_H

#define FANLIGHT_BINDING_CAST_PARAMETERS 0
#define FANLIGHT_BINDING_LIGHT_PARAMETERS 1
#define FANLIGHT_BINDING_VOLUME 2           // 3D texture: column, row, frame by ascending angle
#define FANLIGHT_BINDING_ANGLE_TABLE 3      // texels: frame coordinate by tan(angle / 2)
#define FANLIGHT_BINDING_TRANSFER 4         // 1D texture: colour and opacity of one sample by grey level
#define FANLIGHT_BINDING_FRAMES 5           // texels of four pixels: the frames as they came, by ascending angle
#define FANLIGHT_BINDING_COEFFICIENTS 6     // uvec4 a four pixels: unorm16 pairs of pass 0's guided filter
#define FANLIGHT_BINDING_PREPARED 7         // the same texels after pass 0, to be written
#define FANLIGHT_BINDING_DEPTH 8            // float a pixel: pass 1's depth map, mm
#define FANLIGHT_BINDING_CONFIDENCE 9       // float a pixel: edge contrast over the noise beside it
#define FANLIGHT_BINDING_VOLUME_COLOUR 10   // packed RGBA8 a pixel: pass 1's colours
#define FANLIGHT_BINDING_PREVIOUS 11        // float a pixel: the last volume's steady depth map, mm
#define FANLIGHT_BINDING_STEADY 12          // float a pixel: this one's
#define FANLIGHT_BINDING_CLEANED 13         // float a pixel: without islands, mm
#define FANLIGHT_BINDING_FILLED 14          // float a pixel: with holes filled, mm
#define FANLIGHT_BINDING_WEIGHTS 15         // uint a pixel: what it counts in the filter, 0 without a surface
#define FANLIGHT_BINDING_ROW_SUMS 16        // uvec2 or vec2 a pixel: what the filter's first half leaves
#define FANLIGHT_BINDING_SMOOTH_DEPTH 17    // float a pixel: the filtered depth map, mm
#define FANLIGHT_BINDING_LIT 18             // four halves a pixel: pass 2's picture
#define FANLIGHT_BINDING_DIFFUSED 19        // the same after a step of pass 3's diffusion
#define FANLIGHT_BINDING_FINISHED 20        // packed RGBA8 a pixel: pass 3's picture
#define FANLIGHT_BINDING_NEAREST 21         // uint: the bits of the smallest depth in the filtered map
#define FANLIGHT_BINDING_READY 22           // texels of four pixels: the frames as pass 1 is to see them
#define FANLIGHT_BINDING_COLUMNS 23         // texels of four rows of a column: the same, for gathering
#define FANLIGHT_BINDING_PACKED 24          // these, to be written
#define FANLIGHT_BINDING_BLOCKS 25          // uint a block of a frame: its least and greatest grey level
#define FANLIGHT_BINDING_BOUNDS 26          // uint a block: those of it and the blocks behind it
#define FANLIGHT_BINDING_SEGMENTS 27        // uvec4 a tile: a bit a segment of its rays
#define FANLIGHT_BINDING_TILE_DEPTHS 28     // vec2 a tile of 8 x 8 pixels: its least and greatest depth, mm
#define FANLIGHT_BINDING_UNEVEN 29          // uint a tile: 1 where islands or holes may be
#define FANLIGHT_BINDING_REACHED 30         // uint a tile: no ray of it looked at a sample with this number or a later one
#define FANLIGHT_BINDING_OLD_SEGMENTS 31    // uvec4 a tile: its segments before frames were replaced
#define FANLIGHT_BINDING_TILE_LIST 32       // uint: how many tiles, 1, 1, and their numbers: those to be cast again
#define FANLIGHT_BINDING_BLOCK_TEXELS 33    // the blocks, to be read: lavapipe gathers texels faster than words
#define FANLIGHT_BINDING_BOUND_TEXELS 34    // the bounds, likewise
#define FANLIGHT_BINDINGS 35
// Of these; the others are two uniform buffers, two textures, and texels to read and to write.
#define FANLIGHT_STORAGE_BUFFERS 23

// Pixels of a frame whose grey levels are bounded together, each way; and how many such blocks a bound covers, from its
// own one on.
#define FANLIGHT_BLOCK 4
#define FANLIGHT_BLOCKS_IN_BOUND 4
// Of a tile's rays at most: bits of a uvec4.
#define FANLIGHT_MOST_SEGMENTS 128
// The least number of samples in a segment, as a power of two.
#define FANLIGHT_LEAST_SEGMENT_SHIFT 3

// A depth is never negative, so this cannot be mistaken for one.
#define FANLIGHT_NO_SURFACE -1.0

// No depth is larger.
#define FANLIGHT_FARTHEST 1e9

// What pass 1 keeps along each ray, besides the surface.
#define FANLIGHT_KEEP_NOTHING 0
#define FANLIGHT_KEEP_COLOUR 1
#define FANLIGHT_KEEP_MAXIMUM 2
#define FANLIGHT_KEEP_MINIMUM 3
#define FANLIGHT_KEEP_MEAN 4

// What a picture shows inside the viewport.
#define FANLIGHT_SHOW_SURFACE 0
#define FANLIGHT_SHOW_DEPTH 1
#define FANLIGHT_SHOW_COLOUR 2

// Which tiles pass 1 casts: all, without or with a note of how far their rays looked, or those of a list, with it.
#define FANLIGHT_CAST_ALL 0
#define FANLIGHT_CAST_ALL_NOTED 1
#define FANLIGHT_CAST_LISTED 2

// The confidence counts in whole weights, so that sums are exact.
#define FANLIGHT_MOST_WEIGHT 15

#endif
