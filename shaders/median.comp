// Pass 0: the median over the window, the lower one where there are two, found by halving the range of grey levels.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_8bit_storage : require
#include "bindings.h"
#include "prepare_constants.h"

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
layout(local_size_x = 64) in;  // neighbouring columns; y: the row, z: the frame

// Pixels of the window: side x side in the frame, kAcross frames.
layout(constant_id = 0) const int kSide = 5;
layout(constant_id = 1) const int kAcross = 1;

layout(binding = FANLIGHT_BINDING_FRAMES, scalar) readonly buffer Frames { uint8_t frames[]; };
layout(binding = FANLIGHT_BINDING_PREPARED, scalar) writeonly buffer Prepared { uint8_t prepared[]; };

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  ivec3 size = ivec3(prepare.columns, prepare.rows, prepare.frames);
  if (at.x >= size.x) return;

  int window[kSide * kSide * kAcross];
  int number = 0;
  for (int frame = 0; frame < kAcross; ++frame) {
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        ivec3 from = at + ivec3(column - kSide / 2, row - kSide / 2, frame - kAcross / 2);
        bool inside = all(greaterThanEqual(from, ivec3(0))) && all(lessThan(from, size));
        ivec3 clamped = clamp(from, ivec3(0), size - 1);
        int grey = int(frames[(clamped.z * size.y + clamped.y) * size.x + clamped.x]);
        // What is not there counts as brighter than everything.
        window[(frame * kSide + row) * kSide + column] = inside ? grey : 256;
        number += inside ? 1 : 0;
      }
    }
  }
  // The smallest grey level that at least (number + 1) / 2 of them do not exceed.
  int wanted = (number + 1) / 2;
  int low = 0;
  int high = 255;
  for (int halving = 0; halving < 8; ++halving) {
    int middle = (low + high) / 2;
    int below = 0;
    for (int each = 0; each < kSide * kSide * kAcross; ++each) below += window[each] <= middle ? 1 : 0;
    bool enough = below >= wanted;
    high = enough ? middle : high;
    low = enough ? low : min(middle + 1, 255);
  }
  prepared[(at.z * size.y + at.y) * size.x + at.x] = uint8_t(high);
}
