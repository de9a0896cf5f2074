// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "acquisition/replay/file_facts.hpp"
#include "acquisition/replay/recording.hpp"
#include "proto/base/result.hpp"
#include "proto/model/picture.hpp"

namespace fanlight {

/// Frames of a recording where its geometry puts them in space, to check it by eye: up to eleven of the
/// longest sweep, evenly spread, seen from the side and above. The sweep axis is a violet line, the probe's
/// face a green one in each frame, the borders of the frames are grey. Brighter pixels hide those behind
/// them. Errors: those of Recording::read_frame().
Result<Picture> frames_in_space(Recording& recording);

/// The first and the middle frame side by side. The sector that was found is drawn in: its edges and its
/// face green, its end grey.
Picture frames_side_by_side(const FileFacts& facts);

}  // namespace fanlight
