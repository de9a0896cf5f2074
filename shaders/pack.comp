// SPDX-License-Identifier: Apache-2.0
// Pass 0, on a processor only: packs the frames for the gathering of pass 1 (fan_volume.h). A word holds
// four rows of one column. The last of them is also the first of the next word, so a sample's two rows
// always lie in one word. A trilinear sample then takes four gathered words instead of eight gathered bytes,
// and the packed frames take a third more memory than the frames.
//
// Reads: prepared_frames, words of four pixels of a row (frame_words.h).
// Writes: packed_columns, words of four rows of a column: frame, packed row (every three rows), column;
//   FANLIGHT_PACKED_STRIDE words a packed row.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "buffer_access.h"
#include "prepare_constants.h"

layout(local_size_x = 64) in;  // x: words of a row of the frame; y: packed rows; z: frames

layout(push_constant, scalar) uniform Constants {
  PrepareConstants prepare;
};
FANLIGHT_WORDS_TO_READ(FANLIGHT_BINDING_PREPARED_FRAMES, PreparedFramesWords, prepared_frames);
FANLIGHT_WORDS_TO_WRITE(FANLIGHT_BINDING_PACKED, PackedColumnsWords, packed_columns);
#include "frame_words.h"

void main() {
  int word = int(gl_GlobalInvocationID.x);
  if (word >= words_in_row()) return;
  int packed_row = int(gl_WorkGroupID.y);
  int frame = int(prepare.first_frame + gl_WorkGroupID.z);
  uvec4 columns = uvec4(0u);
  for (int row = 0; row < 4; ++row) {
    int in_frame = min(3 * packed_row + row, int(prepare.rows) - 1);
    columns |= pixels_of(fetched(prepared_frames, int(word_at(word, in_frame, frame)))) << (8 * row);
  }
  uint stride = FANLIGHT_PACKED_STRIDE(prepare.columns);
  int index = int((uint(frame) * gl_NumWorkGroups.y + uint(packed_row)) * stride + 4u * uint(word));
  for (int column = 0; column < 4; ++column) store(packed_columns, index + column, columns[column]);
}
