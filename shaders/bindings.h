// SPDX-License-Identifier: Apache-2.0
// The descriptor set that all passes share, and constants of both languages.
//
// "A pixel", "a tile" and "a block" give the shape of a buffer: maps are height x width of the picture, top
// row first; tiles of 8 x 8 rays or pixels are numbered along their rows.
#ifndef FANLIGHT_SHADERS_BINDINGS_H
#define FANLIGHT_SHADERS_BINDINGS_H

// Uniform buffers.
#define FANLIGHT_BINDING_CAST_PARAMETERS 0
#define FANLIGHT_BINDING_LIGHT_PARAMETERS 1
#define FANLIGHT_BINDING_NEAR_TISSUE 36
#define FANLIGHT_BINDING_STEADY_PARAMETERS 38

// The volume, as passes 0 and 1 read it. Frames are in order of ascending angle.
// 3D texture: column, row, frame.
#define FANLIGHT_BINDING_VOLUME 2
// Pairs of floats: an entry of the angle table and the next one, the frame coordinate by tan(angle / 2).
#define FANLIGHT_BINDING_ANGLE_TABLE 3
// 1D texture: colour and opacity of one sample by its grey level.
#define FANLIGHT_BINDING_TRANSFER 4
// Texels of four pixels: the frames as they were acquired.
#define FANLIGHT_BINDING_FRAMES 5
// uvec4 for four pixels: coefficients of pass 0's guided filter, two unorm16 a pixel.
#define FANLIGHT_BINDING_COEFFICIENTS 6
// Texels of four pixels: the frames after the filter of pass 0, for writing.
#define FANLIGHT_BINDING_FILTERED_FRAMES 7

// Maps of the picture.
// float a pixel: the depth map of pass 1, mm.
#define FANLIGHT_BINDING_DEPTH 8
// float a pixel: the surface that each ray has found, mm. frame_steps.comp makes the depth map from it.
#define FANLIGHT_BINDING_RAY_DEPTH 35
// float a pixel: contrast of the edge over the noise next to it.
#define FANLIGHT_BINDING_CONFIDENCE 9
// Packed RGBA8 a pixel: the colours of pass 1, and in alpha the certainty (certainty.h).
#define FANLIGHT_BINDING_VOLUME_COLOUR 10
// vec2 a pixel of its picture: the steady map of an earlier volume.
#define FANLIGHT_BINDING_EARLIER_MAP 11
// vec2 a pixel: the steady map: depth after the temporal filter, mm, and the number of volumes in it.
#define FANLIGHT_BINDING_STEADY_MAP 12
// float a pixel: the same without islands, mm.
#define FANLIGHT_BINDING_CLEANED 13
// float a pixel: the same with holes filled, mm.
#define FANLIGHT_BINDING_FILLED 14
// uint a pixel: its weight in the depth filter, 0 without a surface.
#define FANLIGHT_BINDING_WEIGHTS 15
// uvec2 or vec2 a pixel: the intermediate result of the depth filter, after the rows.
#define FANLIGHT_BINDING_ROW_SUMS 16
// The same buffer before that: MapAlignment (map_alignment.h). Some drivers have no more than 30 storage
// buffers.
#define FANLIGHT_BINDING_MAP_ALIGNMENT FANLIGHT_BINDING_ROW_SUMS
// float a pixel: the filtered depth map, mm.
#define FANLIGHT_BINDING_SMOOTH_DEPTH 17
// Four half floats a pixel: the picture of pass 2.
#define FANLIGHT_BINDING_LIT 18
// Four half floats a pixel: the same after a step of pass 3, outlines or diffusion; before, the soft light
// (soft_light.h).
#define FANLIGHT_BINDING_DIFFUSED 19
// Packed RGBA8 a pixel: the picture of pass 3.
#define FANLIGHT_BINDING_FINISHED 20
// MapTotals (map_totals.h).
#define FANLIGHT_BINDING_MAP_TOTALS 21

// Further buffers of passes 0 and 1.
// Texels of four pixels: the frames that pass 1 samples, filtered or not.
#define FANLIGHT_BINDING_PREPARED_FRAMES 22
// Texels of four rows of a column: the same, packed for gathering on a processor.
#define FANLIGHT_BINDING_PACKED 23
// uint a block of a frame: its minimum and maximum grey level.
#define FANLIGHT_BINDING_BLOCK_MIN_MAX 25
// uint a block: the minimum and maximum of it and of the blocks to the right and below.
#define FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX 26
// uvec4 a tile of rays: one bit for each segment of its rays, 1 where it has to be sampled.
#define FANLIGHT_BINDING_SEGMENT_MASKS 27

// Tiles.
// vec2 a tile of pixels: its smallest and largest depth, mm.
#define FANLIGHT_BINDING_TILE_DEPTH_RANGES 28
// uint a tile of pixels: 1 where islands, holes or outlines may be.
#define FANLIGHT_BINDING_CLEANUP_TILES 29
// uint a tile of rays: one past the last sample that any of its rays read; with FANLIGHT_CAST_ALL_COUNTED the
// number of samples that all its rays read.
#define FANLIGHT_BINDING_SAMPLE_ENDS 30
// uvec4 a tile of rays: its segment mask before frames were replaced.
#define FANLIGHT_BINDING_OLD_SEGMENT_MASKS 31
// uint: the size of an indirect dispatch (number of tiles, 1, 1), then the numbers of the tiles to cast
// again.
#define FANLIGHT_BINDING_DIRTY_TILES 32

// The block buffers for reading: lavapipe gathers texels faster than words of a storage buffer.
#define FANLIGHT_BINDING_BLOCK_MIN_MAX_TEXELS 33
#define FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX_TEXELS 34

// uint four cells: what the scalpel has cut away (cut_mask.h).
#define FANLIGHT_BINDING_CUT_CELLS 37

#ifdef FANLIGHT_STORAGE
// The same storage buffers for reading and writing (buffer_access.h); the other numbers stay unused.
#undef FANLIGHT_BINDING_BLOCK_MIN_MAX_TEXELS
#undef FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX_TEXELS
#define FANLIGHT_BINDING_BLOCK_MIN_MAX_TEXELS FANLIGHT_BINDING_BLOCK_MIN_MAX
#define FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX_TEXELS FANLIGHT_BINDING_NEIGHBOUR_MIN_MAX
#endif

// Side of a block of a frame, in pixels, and side of the neighbourhood of a block, in blocks.
#define FANLIGHT_BLOCK 4
#define FANLIGHT_BLOCKS_IN_BOUND 4
// Segments of a tile's rays at most: the bits of a uvec4.
#define FANLIGHT_MAX_SEGMENTS 128
// log2 of the smallest number of samples in a segment.
#define FANLIGHT_MIN_SEGMENT_SHIFT 3

// The depth of a pixel without a surface. Depths are never negative.
#define FANLIGHT_NO_SURFACE -1.0

// Upper limit of depths, mm.
#define FANLIGHT_MAX_DEPTH 1e9

// The result of pass 1 along each ray, besides the surface.
#define FANLIGHT_KEEP_NOTHING 0
#define FANLIGHT_KEEP_COLOUR 1
#define FANLIGHT_KEEP_MAXIMUM 2
#define FANLIGHT_KEEP_MINIMUM 3
#define FANLIGHT_KEEP_MEAN 4
#define FANLIGHT_KEEP_LAYERS 5  // the edges behind the surface (glass_layers.h)

// What a column of a frame is, and what grey level 0 means; see FanGeometry.
#define FANLIGHT_FRAMES_PARALLEL 0  // columns are parallel
#define FANLIGHT_FRAMES_POLAR 1     // columns are scan lines of a curved array
#define FANLIGHT_FRAMES_MASKED 2    // columns are parallel, and grey level 0 was not scanned

// Where on its edge the surface lies; see SurfacePlace.
#define FANLIGHT_PLACE_FIRST_CROSSING 0
#define FANLIGHT_PLACE_REFINED 1
#define FANLIGHT_PLACE_TWO_SCALES 2
#define FANLIGHT_PLACE_RIDGE 3
#define FANLIGHT_PLACE_LEVEL 4

// What a slab shows of its echoes; see Slab.
#define FANLIGHT_SLAB_MEAN 0
#define FANLIGHT_SLAB_MAXIMUM 1
#define FANLIGHT_SLAB_X_RAY 2

// The content of a picture inside the viewport.
#define FANLIGHT_SHOW_SURFACE 0
#define FANLIGHT_SHOW_DEPTH 1
#define FANLIGHT_SHOW_COLOUR 2

// The tiles that pass 1 casts: all; all, and their sample ends are written; the dirty tiles, and their sample
// ends are written; or all, and the samples that their rays read are counted instead.
#define FANLIGHT_CAST_ALL 0
#define FANLIGHT_CAST_ALL_NOTED 1
#define FANLIGHT_CAST_LISTED 2
#define FANLIGHT_CAST_ALL_COUNTED 3

// Weights by confidence are whole numbers from 1 to this, so that sums are exact.
#define FANLIGHT_MAX_WEIGHT 15

#endif
