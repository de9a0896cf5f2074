// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

// FILE.pictures.jsonl next to a recording: what it takes to render the pictures that displays saw again, bit
// for bit on the same device. A line is a scene, or a picture that shows the scene of that revision.

/// {"scene_revision": 3, "scene": {...}}
std::string scene_note(std::uint64_t revision, const Scene& scene);
/// {"picture": 17, "volume": 4, "first_frame": 140, "last_frame": 174, "angle_correction_rad": 0.001,
///  "scene_revision": 3, "coarse": false, ..., "levels": {...}, "width": 512, "height": 512}
///
/// `usual`: the server's usual size. Where the picture has another one, the line has "usual_width" and
/// "usual_height" too.
std::string picture_note(const PictureStamp& stamp, PictureSize size, PictureSize usual);

/// A picture that was shown.
struct NotedPicture {
  std::uint64_t picture_id = 0;
  std::uint64_t source_volume_index = 0;
  std::uint64_t first_frame_sequence = 0;
  std::uint64_t last_frame_sequence = 0;
  double angle_correction_rad = 0;
  std::uint64_t scene_revision = 0;
  DeadlineMeasures measures;
  EchoLevels levels;
  PictureSize size;
  PictureSize usual;
};

struct PictureNotes {
  std::map<std::uint64_t, Scene> scenes;  ///< by revision
  std::vector<NotedPicture> pictures;     ///< in the order in which they were shown
};

/// Reads the lines. The file is not trusted: a line that is wrong is an error, kBadInput, with its number.
/// kNotFound: there is no such file.
Result<PictureNotes> read_picture_notes(const std::filesystem::path& path);

}  // namespace fanlight
