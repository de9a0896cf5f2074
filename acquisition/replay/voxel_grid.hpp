// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/replay/frame_reader.hpp"
#include "acquisition/sequence/frame_sequence.hpp"
#include "acquisition/sequence/pixel_values.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// Volumes on a Cartesian grid. The first axis is lateral, the second leads into the body, the third is
/// elevation.
struct VoxelGrid {
  std::array<std::uint32_t, 3> size{};  ///< 2 to 4096 each
  std::array<double, 3> spacing_mm{};
  bool is_left_handed = false;  ///< its axes: the first is turned round then
  std::uint32_t volumes = 1;
  std::vector<double> volume_times_s;  ///< of each volume, rising; empty: not known
  /// Centre of the first voxel in the transducer frame, where the file has it.
  std::optional<std::array<double, 3>> origin_mm;

  std::uint64_t voxels() const { return std::uint64_t{size[0]} * size[1] * size[2]; }  ///< of one volume
};

/// Whether three axis vectors stand at right angles, and their lengths and handedness.
/// `axes`: each vector's x, y, z. nullopt: they do not, or one has no length.
struct AxisVectors {
  std::array<double, 3> lengths{};
  bool is_left_handed = false;
};
std::optional<AxisVectors> orthogonal(const std::array<std::array<double, 3>, 3>& axes);

/// kUnsupported for a grid that makes no fan: sides or sizes out of range, or so flat and wide that the fan
/// would have over eight times its voxels. `name`: of the file, for the message.
Result<void> check(const VoxelGrid& grid, const std::string& name);

/// The renderer knows fans alone, so a grid is read as one: planes through an axis 1000 mm above the face,
/// which are almost parallel. Columns are the grid's own; rows and frames are interpolated linearly between
/// its rows and slices, and stand nowhere further apart than those. Without an origin the middle of its first
/// rows is taken for the centre of the probe's face. Frames have times, angles, and the
/// geometry as Fanlight's fields; a volume is a sweep. Precondition: check().
FrameSequence fan_through(const VoxelGrid& grid, PixelFormat format);

/// Reads those frames. `voxels`: stored values of all volumes, the first axis fastest.
std::unique_ptr<FrameReader> fan_reader(const VoxelGrid& grid, PixelFormat format,
                                        std::vector<std::uint8_t> voxels);

}  // namespace fanlight
