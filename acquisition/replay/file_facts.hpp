// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/replay/recording_file.hpp"
#include "acquisition/sequence/fan_fit.hpp"
#include "acquisition/sequence/sector_guess.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// What is in a file of frames, whether it can be played or not: what it says, and what its frames look like.
struct FileFacts {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::uint32_t frames = 0;
  PixelFormat format;
  bool compressed = false;
  bool scan_lines = false;      ///< a scan line in each row of the file
  std::uint32_t with_time = 0;  ///< frames that have a Timestamp, and so on
  std::uint32_t with_angle = 0;
  std::uint32_t with_volume = 0;
  std::uint32_t with_pose = 0;
  std::uint32_t sweeps = 1;  ///< by VolumeIndex
  std::optional<FrameSequence::PixelSize> pixel_size;
  std::string_view pixel_size_origin;
  std::optional<FanFit> fit;  ///< of the poses
  std::string no_fan;         ///< why the poses form no fan; empty: they do, or there are none
  std::optional<SectorGuess> sector;
  std::optional<StepGuess> step;
  std::vector<std::uint8_t> first_frame;  ///< rows x columns
  std::vector<std::uint8_t> middle_frame;
};

/// Reads the header and up to 64 frames, evenly spread. Errors as of open_recording_file() and
/// SequencePixels::read().
Result<FileFacts> look_into(const std::filesystem::path& path, std::uint64_t max_bytes);

/// Distance of the axis that the poses turn about from the probe's face, as far as the frames show where that
/// is; else from row 0. Precondition: facts.fit.
double axis_behind_face_mm(const FileFacts& facts);

/// A geometry file to edit: what the file says, what was found in its frames (marked GUESS), and what nothing
/// tells (marked UNKNOWN, with a usual value), each rounded to what it is worth. `name`: of the recording.
std::string geometry_draft(const FileFacts& facts, const std::string& name);

/// Writes the draft next to the recording as FILE.toml. kInvalidArgument where that file exists already.
Result<std::filesystem::path> write_geometry_draft(const std::filesystem::path& recording,
                                                   const std::string& draft);

}  // namespace fanlight
