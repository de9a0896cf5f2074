// Pass 0, on a processor: the frames as pass 1 gathers them. A word holds four rows of one column, of which the last is
// also the next word's first, so that a sample and the one below it always lie in one word. A third more memory than
// the frames take, and a trilinear sample is four gathered words instead of eight gathered bytes.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "prepare_constants.h"

layout(local_size_x = 64) in;  // words of a row of the frame; y: the packed row, z: the frame

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
layout(binding = FANLIGHT_BINDING_READY) uniform usamplerBuffer ready;
layout(binding = FANLIGHT_BINDING_PACKED, r32ui) writeonly uniform uimageBuffer packed_columns;
#include "frame_words.h"

void main() {
  int word = int(gl_GlobalInvocationID.x);
  if (word >= words_in_row()) return;
  int packed_row = int(gl_WorkGroupID.y);
  int frame = int(prepare.first_frame + gl_WorkGroupID.z);
  uvec4 columns = uvec4(0u);
  for (int row = 0; row < 4; ++row) {
    int in_frame = min(3 * packed_row + row, int(prepare.rows) - 1);
    columns |= pixels_of(texelFetch(ready, int(word_at(word, in_frame, frame))).x) << (8 * row);
  }
  uint stride = FANLIGHT_PACKED_STRIDE(prepare.columns);
  int index = int((uint(frame) * gl_NumWorkGroups.y + uint(packed_row)) * stride + 4u * uint(word));
  for (int column = 0; column < 4; ++column) imageStore(packed_columns, index + column, uvec4(columns[column]));
}
