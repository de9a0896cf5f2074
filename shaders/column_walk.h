// Sums over the window about each pixel of a frame, for pass 0. An invocation walks down a stretch of one column of one
// frame and keeps the sums of the window's rows, so that a pixel costs one row of its window. Sums are whole
// numbers: what enters one leaves it exactly.
//
// The includer has declared
//   uvec2 entry(uint voxel)                          what a pixel adds
//   void put(uint voxel, uvec2 sum, uint number)     what to do with the sum over a window, of so many pixels
// and the push constants as `prepare`.
#ifndef FANLIGHT_SHADERS_COLUMN_WALK_H
#define FANLIGHT_SHADERS_COLUMN_WALK_H

layout(local_size_x = 64) in;  // neighbouring columns; y: the stretch, z: the frame

// Pixels of the window down a column, odd: a constant, so that the rows' sums live in registers.
layout(constant_id = 0) const int kSide = 5;

const int kStretch = 64;

uint voxel_at(int column, int row, int frame) {
  return (uint(frame) * prepare.rows + uint(row)) * prepare.columns + uint(column);
}

// The window's columns and frames, as far as there are any.
struct Reach {
  int first_column;
  int last_column;
  int first_frame;
  int last_frame;
};

uvec2 row_sum(Reach reach, int row) {
  uvec2 sum = uvec2(0u);
  bool inside = row >= 0 && row < int(prepare.rows);
  int clamped = clamp(row, 0, int(prepare.rows) - 1);
  for (int frame = reach.first_frame; frame <= reach.last_frame; ++frame) {
    for (int column = reach.first_column; column <= reach.last_column; ++column) {
      sum += entry(voxel_at(column, clamped, frame));
    }
  }
  return inside ? sum : uvec2(0u);
}

void walk() {
  int column = int(gl_GlobalInvocationID.x);
  if (column >= int(prepare.columns)) return;
  int frame = int(prepare.first_frame + gl_WorkGroupID.z);
  int first = int(gl_WorkGroupID.y) * kStretch;
  int end = min(first + kStretch, int(prepare.rows));
  const int kRadius = kSide / 2;
  Reach reach = Reach(max(column - kRadius, 0), min(column + kRadius, int(prepare.columns) - 1),
                      max(frame - prepare.radius_across, 0),
                      min(frame + prepare.radius_across, int(prepare.frames) - 1));
  uint across = uint(reach.last_column - reach.first_column + 1) * uint(reach.last_frame - reach.first_frame + 1);

  // The sum of row y lies in slot (y - first + kRadius) % kSide.
  uvec2 rows[kSide];
  uvec2 sum = uvec2(0u);
  for (int slot = 0; slot < kSide; ++slot) rows[slot] = slot < kSide - 1 ? row_sum(reach, first - kRadius + slot) : uvec2(0u);
  for (int slot = 0; slot < kSide; ++slot) sum += rows[slot];
  for (int start = first; start < end; start += kSide) {
    for (int slot = 0; slot < kSide; ++slot) {
      int row = start + slot;
      const int newest = (slot + kSide - 1) % kSide;
      uvec2 entering = row_sum(reach, row + kRadius);
      sum += entering - rows[newest];
      rows[newest] = entering;
      uint down = uint(min(row + kRadius, int(prepare.rows) - 1) - max(row - kRadius, 0) + 1);
      if (row < end) put(voxel_at(column, row, frame), sum, across * down);
    }
  }
}

#endif
